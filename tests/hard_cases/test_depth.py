"""Depth: huge ratios, surfaces at the eye, grazing views, coplanar layers."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hard_cases.hard_scene import box, quad, room, sphere
from hard_cases.invariants import sane
from hard_cases.methods import METHODS, SCREEN_SPACE, label, render

from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.material import Material


def with_meshes(*meshes, **changes):
    """Return the room with other furniture: one white object for each mesh."""
    objects = tuple(SceneObject(i, 0) for i in range(len(meshes)))
    white = (Material(albedo=(0.7, 0.7, 0.7)),)
    return room(meshes=meshes, objects=objects, materials=white, **changes)


CASES = {
    "near/far ratio 1e6": lambda: with_meshes(
        quad((-0.02, -0.02, -0.1), (0.04, 0, 0), (0, 0.04, 0)),
        quad((-1e5, -5e4, -1e5), (2e5, 0, 0), (0, 1e5, 0)),
        camera=Camera((0, 0, 0), (0, 0, -1)),
    ),
    "geometry through the near plane": lambda: with_meshes(
        quad((-5, -0.01, 5), (10, 0, 0), (0, 0, -10)),
        sphere((0, 0, -1.0), 0.3),
        camera=Camera((0, 0, 0), (0, 0, -1)),
    ),
    "camera inside a closed mesh": lambda: with_meshes(
        box((-1, -1, -1), (1, 1, 1)), camera=Camera((0.1, 0.2, 0.3), (1, 0, 0))
    ),
    "camera on a surface": lambda: with_meshes(
        quad((-5, 0, 5), (10, 0, 0), (0, 0, -10)), camera=Camera((0, 0, 0), (0, 0, -1))
    ),
    "plane at 89.9 degrees": lambda: with_meshes(
        quad((-50, 0, 50), (100, 0, 0), (0, 0, -100)),
        camera=Camera((0, 10 * np.tan(np.radians(0.1)), 10), (0, 0, 0)),
    ),
    "wall seen edge-on": lambda: with_meshes(
        quad((0, -1, -1), (0, 0, 2), (0, 2, 0)), camera=Camera((0, 0, 3), (0, 0, 0))
    ),
    "coplanar surfaces": lambda: with_meshes(
        quad((-1, 0, 1), (2, 0, 0), (0, 0, -2)),
        quad((-0.5, 0, 0.5), (1, 0, 0), (0, 0, -1)),
        quad((-0.2, 0, 0.2), (0.4, 0, 0), (0, 0, -0.4)),
    ),
    "empty view": lambda: room(camera=Camera((0, 50, 0), (0, 100, 0))),
}


@pytest.mark.parametrize("method", METHODS, ids=label)
@pytest.mark.parametrize("case", CASES)
def test_images_stay_sane(device, shaders, record, method, case):
    images = render(device, shaders, CASES[case](), method)
    record(case, label(method), sane(images), 0, "insane values")


@pytest.mark.parametrize("method", SCREEN_SPACE[1:], ids=label)
@pytest.mark.parametrize("degrees", [0.0, 45.0, 75.0, 89.0, 89.9])
def test_an_open_plane_is_open_at_any_angle(device, shaders, record, method, degrees):
    """No estimator may find an occluder on the plane itself."""
    if method[1] == "zbuffer":
        pytest.skip("the seed report's variant compares depths in an image box; it cannot")
    angle = np.radians(degrees)
    scene = with_meshes(
        quad((-500, 0, 500), (1000, 0, 0), (0, 0, -1000)),
        camera=Camera((0, 3 * np.cos(angle), 3 * np.sin(angle)), (0, 0, 0), up=(0, 0, -1)),
    )
    # By itself the plane would be known to be open, and nothing would be looked for.
    names = ("visibility", "depth")
    images = render(device, shaders, scene, method, images=names, effects="full")
    covered = images["depth"] > 0.0
    assert covered.any()
    closed = 1.0 - images["visibility"][covered].min()
    record(f"open plane ({method[1]})", label(method), closed, 0.0, "occluded")


def test_far_surfaces_resolve_the_same_depth_as_near_ones(device, shaders, record):
    """z is stored as linear float32: its relative error is the same at any distance."""
    worst = 0.0
    for distance in (0.01, 1.0, 1e3, 1e5):
        scene = with_meshes(
            quad((-distance, -distance, -distance), (2 * distance, 0, 0), (0, 2 * distance, 0)),
            camera=Camera((0, 0, 0), (0, 0, -1)),
        )
        depth = render(device, shaders, scene, ("direct", None), images=("depth",))["depth"]
        worst = max(worst, float(np.abs(depth / distance - 1.0).max()))
    # Interpolation of three float32 vertices: a few roundings of 6e-8.
    record("linear depth from 0.01 to 1e5", "gbuffer", worst, 1e-6, "relative")


def test_cases_show_something(device, shaders):
    """The scenes above are not accidentally empty, but for the one that is meant to be."""
    for case, scene in CASES.items():
        images = render(device, shaders, scene(), ("direct", None), images=("depth",))
        if case not in ("empty view", "wall seen edge-on", "camera on a surface"):
            assert images["depth"].max() > 0.0, case


def test_the_camera_may_sit_anywhere(device, shaders, record):
    """A walk through walls and furniture: every frame is sane."""
    faults = 0
    for step in np.linspace(0.0, 1.0, 9):
        position = (1.3 - 2.6 * step, 1.1 - 0.9 * step, 2.4 - 3.6 * step)
        camera = dataclasses.replace(room().camera, position=position)
        images = render(device, shaders, room(camera=camera), ("bounce", "march"))
        faults += sane(images)
    record("walk through walls", "bounce:march", faults, 0, "insane values")
