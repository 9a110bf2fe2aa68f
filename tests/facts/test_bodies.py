"""Which meshes fill their boxes, and the boxes around bodies."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ssdo_gl import math3d
from ssdo_gl.facts import bodies as content_bodies
from ssdo_gl.facts.bodies import bodies_of, form_of
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry import shapes
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

# Boxes are made by a handful of float64 operations on numbers around 1.
FLOAT64_ERROR = 1e-12


def moved(mesh, vertex, offset):
    positions = mesh.positions.copy()
    positions[vertex] += offset
    return dataclasses.replace(mesh, positions=positions)


PLAIN = (Material(),)


def scene_of(*items, materials=PLAIN):
    """Return a scene of (mesh, matrix) pairs."""
    meshes = tuple(mesh for mesh, _ in items)
    objects = tuple(
        SceneObject(i, 0, np.asarray(matrix)[None]) for i, (_, matrix) in enumerate(items)
    )
    return Scene(meshes, materials, objects, Camera((0, 0, 9), (0, 0, 0)))


@pytest.mark.parametrize(
    "mesh",
    [
        shapes.sphere(),
        shapes.cylinder(),
        shapes.quad(),
        shapes.torus(0.3),
    ],
)
def test_no_other_shape_is_a_box(mesh):
    assert form_of(shapes.box()).is_box and not form_of(mesh).is_box


def test_what_is_almost_a_box_is_not():
    box = shapes.box()
    # Corner 0 of one face pushed in by a billionth of the box.
    assert not form_of(moved(box, 0, -1e-9 * box.positions[0])).is_box
    assert not form_of(dataclasses.replace(box, closed=False)).is_box
    inside_out = dataclasses.replace(box, triangles=box.triangles[:, ::-1].copy())
    assert not form_of(inside_out).is_box
    # One side is missing, and another there twice: closed, as far as the flag says.
    folded = np.concatenate([box.triangles[2:], box.triangles[2:4]])
    assert not form_of(dataclasses.replace(box, triangles=folded)).is_box
    wedge = box.positions.copy()
    wedge[wedge[:, 1] > 0.0, 0] = 0.0
    assert not form_of(dataclasses.replace(box, positions=wedge)).is_box


def test_a_box_may_be_anywhere_of_any_proportions_and_in_many_pieces():
    box = shapes.box()
    placed = dataclasses.replace(
        box, positions=box.positions * [1e-3, 2.0, 70.0] + [1e4, -5.0, 3.0]
    )
    assert form_of(placed).is_box
    # The midpoint of every edge of every triangle, and four triangles for one.
    a, b, c = (box.positions[box.triangles[:, i]] for i in range(3))
    ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
    corners = np.concatenate([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]], axis=1)
    positions = corners.transpose(1, 0, 2).reshape(-1, 3)
    pieces = Mesh(positions, np.arange(len(positions)).reshape(-1, 3), closed=True)
    assert form_of(pieces).is_box


def test_large_meshes_are_given_up_instead_of_looked_through(monkeypatch):
    monkeypatch.setattr(content_bodies, "MOST_BOX_TRIANGLES", 11)
    assert not content_bodies._form_of(shapes.box()).is_box


@pytest.mark.parametrize("limit", [6, 4])
def test_many_meshes_are_known_by_their_boxes_alone(monkeypatch, limit):
    box = shapes.box()
    items = [(dataclasses.replace(box), math3d.translation((3.0 * i, 0.0, 0.0))) for i in range(6)]
    whole = bodies_of(scene_of(*items))
    monkeypatch.setattr(content_bodies, "MOST_MESHES", limit)
    part = bodies_of(scene_of(*items))
    assert list(part.is_box) == [True] * limit + [False] * (6 - limit)
    for field in ("center", "half_edges"):
        assert np.array_equal(getattr(part, field), getattr(whole, field))


def test_a_form_is_found_once(monkeypatch):
    mesh = shapes.box()
    first = form_of(mesh)
    monkeypatch.setattr(content_bodies, "_form_of", None)
    assert form_of(mesh) is first


def test_boxes_hold_their_bodies_under_any_affine_map():
    rng = np.random.default_rng(5)
    matrix = np.eye(4)
    matrix[:3] = rng.normal(size=(3, 4))
    mesh = shapes.torus(0.3)
    bodies = bodies_of(scene_of((mesh, matrix)))
    points = math3d.transform_points(matrix, mesh.positions)
    axes = rng.normal(size=(20, 3))
    middle, reach = bodies.center @ axes.T, bodies.reach_along(axes)
    along = points @ axes.T
    assert np.all(along <= middle + reach + FLOAT64_ERROR)
    assert np.all(along >= middle - reach - FLOAT64_ERROR)


def test_points_inside_a_solid():
    matrix = math3d.translation((5.0, 0.0, 0.0))
    matrix[0, 0] = 4.0
    bodies = bodies_of(scene_of((shapes.box(), matrix), (shapes.box(), np.zeros((4, 4)))))
    assert bodies.holds(0, np.array([6.9, 0.0, 0.0]))
    assert not bodies.holds(0, np.array([7.1, 0.0, 0.0]))
    # A solid without volume can hold anything.
    assert bodies.holds(1, np.array([6.0, 0.0, 0.0]))


def test_a_box_with_holes_is_no_solid():
    lace = (Material(alpha_cutoff=0.5),)
    assert not bodies_of(scene_of((shapes.box(), np.eye(4)), materials=lace)).is_box[0]


def test_instances_are_bodies_of_their_own():
    mesh = shapes.box()
    places = np.stack([math3d.translation((x, 0.0, 0.0)) for x in (0.0, 3.0)])
    objects = (SceneObject(0, 0, places), SceneObject(0, 0, np.eye(4)[None]))
    scene = Scene((mesh,), (Material(),), objects, Camera((0, 0, 9), (0, 0, 0)))
    bodies = bodies_of(scene)
    assert len(bodies) == 3
    np.testing.assert_allclose(bodies.center[:, 0], [0.0, 3.0, 0.0])


def test_a_scene_without_objects():
    empty = Scene((), (), (), Camera((0, 0, 9), (0, 0, 0)))
    assert len(bodies_of(empty)) == 0


def test_mesh_without_use_is_not_kept_alive():
    import gc
    import weakref

    mesh = Mesh(shapes.quad().positions, shapes.quad().triangles)
    form_of(mesh)
    reference = weakref.ref(mesh)
    del mesh
    gc.collect()
    assert reference() is None
