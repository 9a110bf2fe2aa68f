"""Geometry as it comes: needles, slivers, inward and open meshes, crowds in one pixel."""

from __future__ import annotations

import numpy as np
import pytest
from hard_cases.hard_scene import box, quad, room, sphere
from hard_cases.invariants import sane
from hard_cases.methods import METHODS, label, render
from hard_cases.test_depth import with_meshes

from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject

FLOOR = quad((-1, 0, 1), (2, 0, 0), (0, 0, -2))


def needle():
    """A triangle a million times longer than wide."""
    return Mesh(np.array([[-1.0, 0.2, 0], [1, 0.2, 0], [1, 0.2 + 2e-6, 0]]), np.array([[0, 1, 2]]))


def inward(mesh):
    normals = None if mesh.normals is None else -mesh.normals
    return Mesh(mesh.positions, mesh.triangles[:, ::-1], normals=normals, closed=mesh.closed)


def crowd(count):
    """`count` boxes inside one pixel."""
    rng = np.random.default_rng(1)
    matrices = np.tile(np.eye(4), (count, 1, 1))
    matrices[:, :3, :3] *= 1e-4
    matrices[:, :3, 3] = rng.uniform(-2e-3, 2e-3, (count, 3)) + [0, 0.2, 0]
    meshes = (FLOOR, box((-1, -1, -1), (1, 1, 1)))
    objects = (SceneObject(0, 0), SceneObject(1, 1, world_from_object=matrices))
    return room(meshes=meshes, objects=objects)


def odd_normals():
    """Shading normals that face away from, or lie in, their own triangles."""
    mesh = quad((-1, 0, 1), (2, 0, 0), (0, 0, -2))
    normals = np.array([[0, -1.0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    return Mesh(mesh.positions, mesh.triangles, normals=normals)


CASES = {
    "needle triangles": lambda: with_meshes(FLOOR, needle()),
    "one triangle": lambda: with_meshes(
        Mesh(np.array([[-1.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    ),
    "duplicate triangles": lambda: with_meshes(FLOOR, FLOOR, FLOOR),
    "inward normals": lambda: with_meshes(FLOOR, inward(sphere((0, 0.4, 0), 0.4))),
    "open mesh": lambda: with_meshes(
        FLOOR,
        Mesh(
            box((-0.3, 0, -0.3), (0.3, 0.6, 0.3)).positions,
            box((-0.3, 0, -0.3), (0.3, 0.6, 0.3)).triangles[:8],
        ),
    ),
    "normals that disagree with the facets": lambda: with_meshes(odd_normals()),
    "mirrored and squashed instances": lambda: room(
        meshes=(FLOOR, sphere((0, 0, 0), 0.3)),
        objects=(
            SceneObject(0, 0),
            SceneObject(1, 1, np.array([np.diag([-1, 1, 1, 1.0]), np.diag([1, 1e-4, 1, 1.0])])),
        ),
    ),
    "thin poles": lambda: with_meshes(
        FLOOR,
        quad((-1, 0, -1), (2, 0, 0), (0, 2, 0)),
        *(box((x, 0, -0.5), (x + 2e-3, 1.5, -0.498)) for x in np.linspace(-0.9, 0.9, 13)),
    ),
    "one-pixel objects": lambda: with_meshes(
        FLOOR, *(sphere((x, 0.02, z), 0.01, rings=3) for x in (-0.5, 0, 0.5) for z in (-0.5, 0.5))
    ),
    "a crowd in one pixel": lambda: crowd(2000),
    "interpenetrating bodies": lambda: with_meshes(
        FLOOR, box((-0.4, -0.2, -0.4), (0.4, 0.5, 0.4)), sphere((0.3, 0.3, 0.3), 0.4)
    ),
}


@pytest.mark.parametrize("method", METHODS, ids=label)
@pytest.mark.parametrize("case", CASES)
def test_images_stay_sane(device, shaders, record, method, case):
    images = render(device, shaders, CASES[case](), method)
    assert images["depth"].max() > 0.0
    record(case, label(method), sane(images), 0, "insane values")


def test_inward_and_outward_spheres_look_the_same(device, shaders, record):
    """Surfaces are two-sided: winding decides nothing but emission and thickness."""
    camera = Camera((0, 0.6, 2.2), (0, 0.3, 0))
    images = []
    for mesh in (sphere((0, 0.4, 0), 0.4), inward(sphere((0, 0.4, 0), 0.4))):
        scene = with_meshes(FLOOR, mesh, camera=camera)
        images.append(render(device, shaders, scene, ("direct", None), shadows="none"))
    gap = np.abs(images[0]["direct"] - images[1]["direct"]).max() / images[0]["direct"].mean()
    # Normals are stored with 16 bits per octahedral axis: 6.5e-5 rad.
    record("two-sided shading", "direct", float(gap), 1e-3, "relative")


@pytest.fixture(scope="module")
def million():
    return crowd(1_000_000 // 12)


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS, ids=label)
def test_a_million_triangles_in_one_pixel(device, shaders, record, million, method):
    images = render(device, shaders, million, method)
    assert images["depth"].max() > 0.0
    record("1e6 triangles in a pixel", label(method), sane(images), 0, "insane values")
