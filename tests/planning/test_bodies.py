"""Which meshes fill their boxes, and the boxes around bodies."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ssdo_gl import math3d
from ssdo_gl.planning import bodies as content_bodies
from ssdo_gl.planning.bodies import ANY, FLAT, SOLID_BOX, bodies_of, form_of
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
    ("mesh", "form"),
    [
        (shapes.box(), SOLID_BOX),
        (shapes.sphere(), ANY),
        (shapes.cylinder(), ANY),
        (shapes.cone(), ANY),
        (shapes.quad(), FLAT),
        (shapes.torus(0.3), ANY),
        (shapes.sphere(bump_amplitude=0.1), ANY),
    ],
)
def test_primitive_shapes(mesh, form):
    assert form_of(mesh).form == form


def test_what_is_almost_a_box_is_not():
    box = shapes.box()
    # Corner 0 of one face pushed in by a billionth of the box.
    assert form_of(moved(box, 0, -1e-9 * box.positions[0])).form == ANY
    assert form_of(dataclasses.replace(box, closed=False)).form == ANY
    inside_out = dataclasses.replace(box, triangles=box.triangles[:, ::-1].copy())
    assert form_of(inside_out).form == ANY
    # One side is missing, and another there twice: closed, as far as the flag says.
    folded = np.concatenate([box.triangles[2:], box.triangles[2:4]])
    assert form_of(dataclasses.replace(box, triangles=folded)).form == ANY
    wedge = box.positions.copy()
    wedge[wedge[:, 1] > 0.0, 0] = 0.0
    assert form_of(dataclasses.replace(box, positions=wedge)).form == ANY


def test_a_box_may_be_anywhere_of_any_proportions_and_in_many_pieces():
    box = shapes.box()
    placed = dataclasses.replace(
        box, positions=box.positions * [1e-3, 2.0, 70.0] + [1e4, -5.0, 3.0]
    )
    assert form_of(placed).form == SOLID_BOX
    # The midpoint of every edge of every triangle, and four triangles for one.
    a, b, c = (box.positions[box.triangles[:, i]] for i in range(3))
    ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
    corners = np.concatenate([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]], axis=1)
    positions = corners.transpose(1, 0, 2).reshape(-1, 3)
    pieces = Mesh(positions, np.arange(len(positions)).reshape(-1, 3), closed=True)
    assert form_of(pieces).form == SOLID_BOX


def test_what_is_almost_flat_is_not():
    assert form_of(moved(shapes.quad(), 2, [0.0, 0.0, 1e-9])).form == ANY


def test_a_bump_between_the_vertices_of_the_first_look_is_found():
    grid = np.stack(np.meshgrid(np.arange(30.0), np.arange(30.0), [0.0]), axis=-1).reshape(-1, 3)
    vertex = next(i for i in range(400, 900) if i % (900 // content_bodies.FIRST_LOOK_VERTICES))
    corners = np.array([[i, i + 1, i + 31] for i in range(869) if i % 30 != 29])
    far_from_bump = corners[np.abs(corners[:, 0] - vertex) > 64]
    sheet = Mesh(grid, far_from_bump)
    assert form_of(sheet).form == FLAT
    assert form_of(moved(sheet, vertex, [0.0, 0.0, 0.1])).form == ANY


def test_large_meshes_are_given_up_instead_of_looked_through(monkeypatch):
    monkeypatch.setattr(content_bodies, "MOST_BOX_TRIANGLES", 11)
    assert content_bodies._form_of(shapes.box()).form == ANY


@pytest.mark.parametrize("limit", [6, 4])
def test_many_meshes_are_known_by_their_boxes_alone(monkeypatch, limit):
    box = shapes.box()
    items = [(dataclasses.replace(box), math3d.translation((3.0 * i, 0.0, 0.0))) for i in range(6)]
    whole = bodies_of(scene_of(*items))
    monkeypatch.setattr(content_bodies, "MOST_MESHES", limit)
    part = bodies_of(scene_of(*items))
    assert list(part.form) == [SOLID_BOX] * limit + [ANY] * (6 - limit)
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
    axes = content_bodies.unit(rng.normal(size=(20, 3)))
    middle, reach = bodies.center @ axes.T, bodies.reach_along(axes)
    along = points @ axes.T
    assert np.all(along <= middle + reach + FLOAT64_ERROR)
    assert np.all(along >= middle - reach - FLOAT64_ERROR)
    assert np.all(np.linalg.norm(points - bodies.center, axis=1) <= bodies.radius + FLOAT64_ERROR)


def test_face_axes_stand_on_the_faces_of_the_box():
    matrix = math3d.rotation_euler(np.array([20.0, 30.0, 40.0]))
    bodies = bodies_of(scene_of((shapes.box(), matrix)))
    for k in range(3):
        others = [bodies.half_edges[0, (k + i) % 3] for i in (1, 2)]
        np.testing.assert_allclose(np.linalg.norm(bodies.face_axes[0, k]), 1.0)
        np.testing.assert_allclose(np.array(others) @ bodies.face_axes[0, k], 0.0, atol=1e-15)


def test_a_flat_sheet_keeps_its_plane_through_any_map():
    matrix = math3d.translation((1.0, 2.0, 3.0)) @ math3d.rotation_euler(np.array([0.0, 50.0, 9.0]))
    matrix[:3, :3] *= [[2.0, 1.0, 0.5]]
    bodies = bodies_of(scene_of((shapes.quad(), matrix)))
    plane = bodies.flat_plane_ws(0)
    points = math3d.transform_points(matrix, shapes.quad().positions)
    np.testing.assert_allclose(points @ plane[:3] + plane[3], 0.0, atol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(plane[:3]), 1.0)


def test_points_inside_a_solid():
    matrix = math3d.translation((5.0, 0.0, 0.0))
    matrix[0, 0] = 4.0
    bodies = bodies_of(scene_of((shapes.box(), matrix), (shapes.box(), np.zeros((4, 4)))))
    assert bodies.holds(0, np.array([6.9, 0.0, 0.0]))
    assert not bodies.holds(0, np.array([7.1, 0.0, 0.0]))
    # A solid without volume can hold anything.
    assert bodies.holds(1, np.array([6.0, 0.0, 0.0]))


def test_a_solid_with_holes_is_no_solid_but_a_sheet_with_holes_is_flat():
    lace = (Material(alpha_cutoff=0.5),)
    scene = scene_of((shapes.box(), np.eye(4)), (shapes.quad(), np.eye(4)), materials=lace)
    assert list(bodies_of(scene).form) == [ANY, FLAT]


def test_instances_are_bodies_of_their_own_and_know_their_light():
    mesh = shapes.box()
    places = np.stack([math3d.translation((x, 0.0, 0.0)) for x in (0.0, 3.0)])
    objects = (SceneObject(0, 0, places), SceneObject(0, 0, np.eye(4)[None], light=7))
    scene = Scene((mesh,), (Material(),), objects, Camera((0, 0, 9), (0, 0, 0)))
    bodies = bodies_of(scene)
    assert len(bodies) == 3
    assert list(bodies.light) == [-1, -1, 7]
    np.testing.assert_allclose(bodies.center[:, 0], [0.0, 3.0, 0.0])


def test_a_scene_without_objects():
    empty = Scene((), (), (), Camera((0, 0, 9), (0, 0, 0)))
    assert len(bodies_of(empty)) == 0


def test_a_degenerate_mesh_of_many_points_is_boxed(monkeypatch):
    monkeypatch.setattr(content_bodies, "MOST_OUTLINE_POINTS", 3)
    form = content_bodies._form_of(shapes.quad())
    assert form.form == FLAT and len(form.outline) == 8


def test_mesh_without_use_is_not_kept_alive():
    import gc
    import weakref

    mesh = Mesh(shapes.quad().positions, shapes.quad().triangles)
    form_of(mesh)
    reference = weakref.ref(mesh)
    del mesh
    gc.collect()
    assert reference() is None
