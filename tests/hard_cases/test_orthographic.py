"""Parallel rays: every method sees through them as it does through a pinhole.

What is in the picture, and how large, does not depend on where along its axis the camera
stands; all else must agree with closed forms, with rays, and with itself after a move.
"""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest
from hard_cases.hard_scene import CAMERA, box, quad, room, transformed
from hard_cases.invariants import difference, sane
from hard_cases.methods import METHODS, label, render
from oracle.closed_forms import corner_occlusion

from ssdo_gl import math3d
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment.environment_kinds import ConstantEnvironment
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.lights import DirectionalLight, PointLight
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

PARALLEL = CAMERA.orthographic(2.2)
RADIANCES = ("beauty", "direct", "directional", "bounce", "visibility")
# As in test_scale_and_place.py: a handful of samples within rounding of an edge flip.
FLIPPED_PIXELS, FLIPPED_RMSE = 0.01, 0.02
# Depth of the far wall over float32's last bit, and some tens of roundings on the way.
POSITION_ERROR = 2e-6
ALBEDO = 0.5


def scene_of(*meshes, camera, lights=(), environment=None):
    objects = tuple(SceneObject(i, 0) for i in range(len(meshes)))
    material = Material(albedo=(ALBEDO, ALBEDO, ALBEDO))
    return Scene(tuple(meshes), (material,), objects, camera, tuple(lights), environment)


def pixel_centres(camera, size):
    """Return world-space points (h, w, 3) in the plane of the camera, row 0 at the top."""
    width, height = size
    right, up, _ = camera.view_from_world_rotation()
    half = camera.half_frame(width / height)
    x = (2.0 * (np.arange(width) + 0.5) / width - 1.0) * half[0]
    y = (1.0 - 2.0 * (np.arange(height) + 0.5) / height) * half[1]
    return np.asarray(camera.position) + x[None, :, None] * right + y[:, None, None] * up


def test_positions_and_depths_of_a_tilted_plane(device, shaders):
    """A floor seen from aslant: where each pixel's line meets y = 0."""
    camera = Camera((2.0, 3.0, 4.0), (0.0, 0.0, 0.0), height=2.0)
    scene = scene_of(quad((-9, 0, 9), (18, 0, 0), (0, 0, -18)), camera=camera)
    images = render(
        device, shaders, scene, ("direct", None), images=("depth", "position_ws"), radius=1.0
    )
    start = pixel_centres(camera, (64, 48))
    ahead = -camera.view_from_world_rotation()[2]
    depth = start[:, :, 1] / -ahead[1]
    np.testing.assert_allclose(images["depth"][:, :, 0], depth, atol=POSITION_ERROR)
    exact = start + depth[:, :, None] * ahead
    np.testing.assert_allclose(images["position_ws"], exact, atol=POSITION_ERROR)


def test_direct_light_of_a_plane(device, shaders):
    """albedo / pi times the irradiance of a sun and of a point light, cosine over distance^2."""
    camera = Camera((2.0, 3.0, 4.0), (0.0, 0.0, 0.0), height=2.0)
    down = tuple(math3d.normalized([0.3, -1.0, 0.2]))
    lights = (DirectionalLight(down, (2.0, 2.0, 2.0)), PointLight((0.2, 0.7, 0.1), (1.0, 1.0, 1.0)))
    scene = scene_of(quad((-9, 0, 9), (18, 0, 0), (0, 0, -18)), camera=camera, lights=lights)
    found = render(
        device, shaders, scene, ("direct", None), images=("direct", "position_ws"), radius=1.0
    )
    to_light = np.array([0.2, 0.7, 0.1]) - found["position_ws"].astype(np.float64)
    distance = np.linalg.norm(to_light, axis=2)
    irradiance = -2.0 * down[1] + to_light[:, :, 1] / distance**3
    exact = ALBEDO / np.pi * irradiance
    np.testing.assert_allclose(found["direct"][:, :, 0], exact, rtol=1e-4)


# Noise of 256 directions after the filter, of pixels a hundredth of R wide.
CORNER_RMSE = {"march": 0.02, "reference": 0.012}


@pytest.mark.parametrize("method", [("ssdo", "march"), ("reference-near", None)], ids=label)
def test_open_directions_before_a_wall(device, shaders, record, method):
    """Floor and wall at a right angle: the closed form of the cosine-weighted wedge."""
    camera = Camera((0.0, 3.0, 3.0), (0.0, 0.4, 0.4), height=2.4)
    floor, wall = (
        quad((-30, 0, 30), (60, 0, 0), (0, 0, -30)),
        quad((-30, 0, 0), (60, 0, 0), (0, 30, 0)),
    )
    scene = scene_of(floor, wall, camera=camera, environment=ConstantEnvironment((1.0, 1.0, 1.0)))
    images = render(
        device,
        shaders,
        scene,
        method,
        images=("visibility", "position_ws"),
        size=(96, 96),
        radius=1.0,
        samples=1024,
        steps=16,
        spp=256,
    )
    place = images["position_ws"].astype(np.float64)
    distance = np.maximum(place[:, :, 1], place[:, :, 2])
    # Far enough from the border that nothing within R is outside the frame.
    known = (distance > 0.03) & (distance < 0.85) & (np.abs(place[:, :, 0]) < 0.15)
    error = images["visibility"][:, :, 0] - (1.0 - corner_occlusion(distance))
    kind = "reference" if method[0].startswith("reference") else "march"
    rmse = float(np.sqrt(np.mean(error[known] ** 2)))
    record("wedge between parallel rays", label(method), rmse, CORNER_RMSE[kind], "RMSE")


@pytest.fixture(scope="module")
def base(device, shaders):
    """Return a function that renders the room between parallel rays once for each method."""
    return cache(lambda method: render(device, shaders, room(camera=PARALLEL), method))


@pytest.mark.parametrize("method", METHODS, ids=label)
@pytest.mark.parametrize("distance", [30.0, 3e5])
def test_how_far_the_camera_stands_does_not_show(device, shaders, base, record, method, distance):
    near = base(method)
    ahead = math3d.normalized(np.subtract(PARALLEL.target, PARALLEL.position))
    away = dataclasses.replace(
        PARALLEL, position=tuple(np.subtract(PARALLEL.position, distance * ahead).tolist())
    )
    far = render(device, shaders, room(camera=away), method)
    for name in RADIANCES:
        rmse, flipped = difference(near, far, name)
        record("a far camera", label(method), rmse, FLIPPED_RMSE, "rel. RMSE")
        record("a far camera: pixels", label(method), flipped, FLIPPED_PIXELS, "share changed")
    hit = near["depth"] > 0.0
    assert np.array_equal(hit, far["depth"] > 0.0)
    np.testing.assert_allclose(
        far["depth"][hit] - distance, near["depth"][hit], atol=distance * 1e-6
    )


@pytest.mark.parametrize("method", METHODS, ids=label)
@pytest.mark.parametrize("place", ["1e-3", "1e4", "offset"])
def test_place_and_scale_do_not_show(device, shaders, base, record, method, place):
    matrix = (
        math3d.translation([1e5, -1e5, 1e5]) if place == "offset" else math3d.scaling(float(place))
    )
    before = base(method)
    other = render(device, shaders, transformed(room(camera=PARALLEL), matrix), method)
    assert sane(before) == sane(other) == 0
    for name in RADIANCES:
        rmse, flipped = difference(before, other, name)
        record(f"parallel, {place}", label(method), rmse, FLIPPED_RMSE, "rel. RMSE")
        record(f"parallel, {place}: pixels", label(method), flipped, FLIPPED_PIXELS, "share")


def test_a_mirrored_scene_gives_the_mirrored_image(device, shaders, base):
    before = base(("direct", None))
    mirrored = transformed(room(camera=PARALLEL), np.diag([-1.0, 1.0, 1.0, 1.0]))
    other = render(device, shaders, mirrored, ("direct", None))
    np.testing.assert_allclose(other["depth"][:, ::-1], before["depth"], rtol=1e-5)


# From 60 away a pinhole shows the room's near and far end 1.5 % larger and smaller: pixels
# of silhouettes shift by one at most, and means by the noise of few directions.
FAR_AWAY = 60.0
NEARLY_PARALLEL = 0.04
# Mere depths have a bias that grows with the distance of the camera.
FREE_OF_DISTANCE = tuple(method for method in METHODS if method[1] != "zbuffer")


@pytest.mark.parametrize("method", FREE_OF_DISTANCE, ids=label)
def test_parallel_rays_are_the_limit_of_a_pinhole_far_away(device, shaders, record, method):
    target = np.asarray(PARALLEL.target)
    ahead = math3d.normalized(target - PARALLEL.position)
    angle = 2.0 * np.degrees(np.arctan(0.5 * PARALLEL.height / FAR_AWAY))
    pinhole = Camera(tuple((target - FAR_AWAY * ahead).tolist()), PARALLEL.target, fov_y=angle)
    far = render(device, shaders, room(camera=pinhole), method, samples=64, spp=64)
    found = render(device, shaders, room(camera=PARALLEL), method, samples=64, spp=64)
    for name in RADIANCES:
        mean = far[name][..., :3].mean()
        gap = abs(found[name][..., :3].mean() - mean) / max(mean, 1e-9)
        record("mean, against a far pinhole", label(method), gap, NEARLY_PARALLEL, "rel. mean")


def test_maps_agree_with_traced_shadows(device, shaders, record):
    scene = room(camera=PARALLEL)
    by_map = render(device, shaders, scene, ("direct", None), shadows="map", maps={})
    traced = render(device, shaders, scene, ("direct", None), shadows="traced", shadow_rays=256)
    rmse, _ = difference(traced, by_map, "direct")
    record("maps and traced shadows", "direct", rmse, 0.08, "rel. RMSE")


def test_a_furnace_between_parallel_rays_is_exact(device, shaders):
    """Under a sky of one colour an open plane sends on its albedo, whatever the view."""
    camera = Camera((0.0, 5.0, 3.0), (0.0, 0.0, 0.0), height=2.0)
    white = ConstantEnvironment((1.0, 1.0, 1.0))
    scene = scene_of(quad((-9, 0, 9), (18, 0, 0), (0, 0, -18)), camera=camera, environment=white)
    for method in METHODS[1:]:
        if method[1] in ("zbuffer", "rgs09"):
            # Mere depths take a tilted plane for steps; uniform directions leave noise.
            continue
        beauty = render(device, shaders, scene, method, radius=0.5)["beauty"]
        np.testing.assert_allclose(beauty[:, :, :3], ALBEDO, rtol=2e-3, err_msg=label(method))


def test_what_is_behind_the_camera_is_cut_off(device, shaders):
    """The camera's plane cuts a box open: its inside shows, from its far side on."""
    camera = Camera((0.0, 0.0, 0.0), (0.0, 0.0, -1.0), height=4.0)
    scene = scene_of(box((-1, -1, -1), (1, 1, 1)), box((-9, -9, 2), (9, 9, 3)), camera=camera)
    depth = render(device, shaders, scene, ("direct", None), radius=1.0)["depth"][:, :, 0]
    seen = depth[depth > 0.0]
    np.testing.assert_allclose(seen, 1.0, rtol=1e-5)
    assert seen.size == 24 * 24


def test_a_sky_is_one_colour_between_parallel_rays(device, shaders):
    scene = scene_of(
        box((-0.1, -0.1, -0.1), (0.1, 0.1, 0.1)),
        camera=Camera((1.0, 2.0, 3.0), (0.0, 0.0, 0.0), height=2.0),
        environment=ConstantEnvironment((0.2, 0.3, 0.4)),
    )
    for method in (("ssdo", "march"), ("reference-gi", None)):
        beauty = render(device, shaders, scene, method, radius=1.0)["beauty"]
        sky = beauty[beauty[:, :, 3] == 0.0]
        np.testing.assert_allclose(
            sky[:, :3], np.broadcast_to((0.2, 0.3, 0.4), (len(sky), 3)), rtol=1e-5
        )
