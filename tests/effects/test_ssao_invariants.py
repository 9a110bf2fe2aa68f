"""Visibility from the depth buffer: what must hold whatever the picture."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from oracle import analytic_pictures
from oracle.analytic_pictures import Plane, Sphere
from passes.estimator_cases import (
    ball_on_floor,
    corner,
    picture_frame,
    positions,
    random_picture,
    run_visibility,
    tilted_plane,
)
from passes.pass_harness import make_frame, make_scene, quad, run_pass

from ssdo_gl.effects.ssao import SsaoPass, SsaoSettings
from ssdo_gl.gpu.geometry import Geometry
from ssdo_gl.passes.gbuffer import GBufferPass
from ssdo_gl.scene.camera import Camera
from ssdo_gl.settings import estimators as registry

SIZE = (48, 36)
TAN_Y = 0.5
ESTIMATORS = tuple(name for name in registry.ESTIMATORS if name != "zbuffer")
WIDE_SIZE = (160, 96)
WIDE_TAN = 0.25


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
@pytest.mark.parametrize("degrees", [0.0, 45.0, 75.0, 85.0, 89.0, 89.9])
def test_open_plane_is_exactly_open(gl, shaders, degrees, scale, estimator):
    size = (64, 48)
    frame = picture_frame(size, TAN_Y, near=0.01 * scale)
    picture = tilted_plane(degrees, size, frame.view.tan_half_fov, scale)
    for radius in (0.2, 3.0, np.inf):
        settings = SsaoSettings(estimator=estimator, radius=radius * scale, samples=64)
        assert np.all(run_visibility(gl, shaders, picture, settings, frame) == 1.0)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
@pytest.mark.parametrize("degrees", [30.0, 75.0, 89.0, 89.9])
def test_rasterized_plane_is_exactly_open(gl, shaders, degrees, scale):
    """With the depths and normals that the G-buffer pass leaves, far from the origin."""
    size = (96, 72)
    angle = np.radians(degrees)
    across = np.array([2.0, -1.0, 0.0]) / np.sqrt(5.0)
    normal = np.array([0.0, 0.0, 1.0]) * np.cos(angle) + across * np.sin(angle)
    u = np.cross(normal, [0.3, 1.0, 0.2])
    u /= np.linalg.norm(u)
    v = np.cross(normal, u)
    eye = np.full(3, 100.0 * scale)
    corner_ws = eye + scale * (np.array([0.0, 0.0, -3.0]) - 20.0 * u - 20.0 * v)
    mesh = quad(corner_ws, 40.0 * scale * u, 40.0 * scale * v)
    camera = Camera(tuple(eye), tuple(eye - [0.0, 0.0, scale]), fov_y=53.0)
    scene = make_scene([mesh], camera=camera)
    geometry = Geometry(gl, scene)
    frame = make_frame(scene, size, geometry=geometry)
    gbuffer = run_pass(gl, shaders, GBufferPass(), frame, geometry=geometry)
    geometry.release()
    covered = gbuffer["z_vs"][..., 0] > 0.0
    assert covered.sum() > 1000
    inputs = {name: gbuffer[name] for name in ("z_vs", "normals_vs")}
    for estimator in ESTIMATORS:
        for radius in (0.2, 3.0, np.inf):
            settings = SsaoSettings(estimator=estimator, radius=radius * scale, bias=0.0)
            image = run_pass(gl, shaders, SsaoPass(settings), frame, inputs)["visibility_raw"]
            assert np.all(image[covered][:, 0] == 1.0)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_convex_body_is_exactly_open(gl, shaders, estimator):
    frame = picture_frame(SIZE, TAN_Y)
    ball = analytic_pictures.cast([Sphere((0, 0, -3), 1.0)], SIZE, frame.view.tan_half_fov)
    settings = SsaoSettings(estimator=estimator, radius=0.5, samples=64)
    assert np.all(run_visibility(gl, shaders, ball, settings, frame) == 1.0)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_power_of_two_scale_changes_nothing(gl, shaders, estimator):
    """Lengths scaled by 2^k scale every float exactly: the images must be equal."""
    frame = picture_frame(SIZE, TAN_Y)
    picture = random_picture(6, SIZE, frame.view.tan_half_fov, True)
    settings = SsaoSettings(estimator=estimator, radius=1.0, samples=32)
    reference = run_visibility(gl, shaders, picture, settings, frame)
    for scale in (2.0**-10, 2.0**13):
        scaled = dataclasses.replace(
            picture, z=picture.z * scale, z_back=picture.z_back * scale, near=picture.near * scale
        )
        found = run_visibility(
            gl,
            shaders,
            scaled,
            dataclasses.replace(settings, radius=scale),
            picture_frame(SIZE, TAN_Y, near=picture.near * scale),
        )
        np.testing.assert_array_equal(found, reference)


# Larger reaches move the steps, so single directions may open; means may not by more than
# the error of some 16 x 16 directions each.
MEAN_TOLERANCE = 2e-3


@pytest.mark.parametrize("estimator", ["march", "bitmask", "gtao", "hbao"])
def test_larger_radius_never_brightens(gl, shaders, estimator):
    frame = picture_frame(WIDE_SIZE, WIDE_TAN)
    for picture in (
        corner(WIDE_SIZE, frame.view.tan_half_fov),
        ball_on_floor(WIDE_SIZE, frame.view.tan_half_fov),
    ):
        means = []
        for radius in (0.05, 0.1, 0.2, 0.4, 0.8, 1.6, np.inf):
            settings = SsaoSettings(estimator=estimator, radius=radius, samples=128)
            means.append(run_visibility(gl, shaders, picture, settings, frame).mean())
        assert np.all(np.diff(means) < MEAN_TOLERANCE)
        assert means[-1] < means[0] - 0.01


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_endless_radius_still_finds_a_wall(gl, shaders, estimator):
    """Single points are spread over what of a ray is in the frame, not over infinity."""
    frame = picture_frame(WIDE_SIZE, WIDE_TAN)
    picture = corner(WIDE_SIZE, frame.view.tan_half_fov)
    settings = SsaoSettings(estimator=estimator, radius=np.inf, samples=64)
    found = run_visibility(gl, shaders, picture, settings, frame)
    # Two walls at a right angle cover half of each other's hemispheres; near the edge
    # where they meet most of that is in the frame.
    assert found[40:56, 60:100].mean() < 0.75


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_mirrored_picture_gives_the_mirrored_image(gl, shaders, estimator):
    """On average over blocks: the sample pattern itself is not symmetric."""
    frame = picture_frame(WIDE_SIZE, WIDE_TAN)
    picture = ball_on_floor(WIDE_SIZE, frame.view.tan_half_fov)
    settings = SsaoSettings(estimator=estimator, radius=0.6, samples=256)
    found = run_visibility(gl, shaders, picture, settings, frame)
    blocks = found.reshape(24, 4, 40, 4).mean((1, 3))
    # One block in which a silhouette falls differently may differ; not their mean.
    assert np.abs(blocks - blocks[:, ::-1]).mean() < 3 * MEAN_TOLERANCE


@pytest.mark.parametrize("estimator", [*ESTIMATORS, "zbuffer"])
def test_sky_is_open_and_blocks_nothing(gl, shaders, estimator):
    frame = picture_frame(SIZE, TAN_Y)
    empty = analytic_pictures.cast([], SIZE, frame.view.tan_half_fov)
    settings = SsaoSettings(estimator=estimator, radius=1.0)
    assert np.all(run_visibility(gl, shaders, empty, settings, frame) == 1.0)
    # A disc of floor in the middle of nothing.
    picture = tilted_plane(30.0, SIZE, frame.view.tan_half_fov)
    far = np.linalg.norm(positions(picture) - [0, 0, -3], axis=-1) > 0.5
    island = dataclasses.replace(picture, z=np.where(far, 0.0, picture.z))
    if estimator != "zbuffer":
        assert np.all(run_visibility(gl, shaders, island, settings, frame) == 1.0)


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("radius", [0.0, 1e-30, 0.02])
def test_radius_below_a_pixel_is_open(gl, shaders, estimator, radius):
    """At depth 3 a pixel of this frame covers 0.08."""
    frame = picture_frame(SIZE, TAN_Y)
    picture = corner(SIZE, frame.view.tan_half_fov)
    settings = SsaoSettings(estimator=estimator, radius=radius)
    assert np.all(run_visibility(gl, shaders, picture, settings, frame) == 1.0)


def test_radius_of_exactly_a_pixel_is_the_limit(gl, shaders):
    """A pixel covers z / 36 here, so a radius of .06 is below a pixel from depth 2.16 on."""
    frame = picture_frame(SIZE, TAN_Y)
    picture = random_picture(9, SIZE, frame.view.tan_half_fov, False)
    settings = SsaoSettings(estimator="march", radius=0.06, samples=64, thickness=np.inf)
    found = run_visibility(gl, shaders, picture, settings, frame)
    assert np.all(found[picture.z > 2.161] == 1.0)
    assert found[(picture.z > 0.0) & (picture.z < 2.159)].min() < 1.0


@pytest.mark.parametrize("estimator", [*ESTIMATORS, "zbuffer"])
@pytest.mark.parametrize("samples, steps", [(1, 1), (1, 8), (5, 2), (64, 64)])
def test_any_sample_count_stays_in_range(gl, shaders, estimator, samples, steps):
    frame = picture_frame(SIZE, TAN_Y)
    picture = random_picture(8, SIZE, frame.view.tan_half_fov, True)
    settings = SsaoSettings(estimator=estimator, radius=1.0, samples=samples, steps=steps)
    found = run_visibility(gl, shaders, picture, settings, frame)
    assert np.all((found >= 0.0) & (found <= 1.0))
    assert found.min() < 1.0


def test_thin_pole_needs_the_back_layer(gl, shaders):
    """A pole far before a wall: within R of the wall seen from the camera, but its back
    is not. Without the layer the wall darkens as if the pole reached it."""
    frame = picture_frame(WIDE_SIZE, WIDE_TAN)
    surfaces = [Plane((0, 0, -5), (0, 0, 1)), Sphere((0, 0, -3), 0.1)]
    picture = analytic_pictures.cast(surfaces, WIDE_SIZE, frame.view.tan_half_fov)
    settings = SsaoSettings(estimator="march", radius=1.0, samples=128, thickness=3.0)
    with_back = run_visibility(gl, shaders, picture, settings, frame)
    without = run_visibility(gl, shaders, picture, settings, frame, has_back=False)
    wall = picture.z > 4.0
    assert np.all(with_back[wall] == 1.0)
    assert without[wall].min() < 0.9


def test_seed_decides_the_pattern(gl, shaders):
    frame = picture_frame(SIZE, TAN_Y)
    picture = corner(SIZE, frame.view.tan_half_fov)
    settings = SsaoSettings(radius=0.5, samples=4)
    images = [
        run_visibility(gl, shaders, picture, settings, picture_frame(SIZE, TAN_Y, seed=seed))
        for seed in (1, 1, 2)
    ]
    np.testing.assert_array_equal(images[0], images[1])
    assert np.any(images[0] != images[2])


def test_zbuffer_darkens_below_nearer_texels(gl, shaders):
    """A step in depth: the far side darkens within the box, the near side does not."""
    frame = picture_frame(SIZE, TAN_Y)
    picture = tilted_plane(0.0, SIZE, frame.view.tan_half_fov)
    step = dataclasses.replace(picture, z=np.where(np.arange(48) < 24, 2.0, 3.0) * np.ones((36, 1)))
    settings = SsaoSettings(estimator="zbuffer", samples=64, box_px=6.0)
    found = run_visibility(gl, shaders, step, settings, frame)
    assert np.all(found[:, :24] == 1.0)
    assert np.all(found[:, 24 + 7 :] == 1.0)
    # The first far column sees 6 of its box's 13 columns nearer; the pattern's error is
    # that of 64 samples.
    assert found[:, 24].mean() == pytest.approx(1.0 - 6.0 / 13.0, abs=0.04)
