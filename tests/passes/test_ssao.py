"""Visibility from the depth buffer: closed forms, the float64 twin, invariants."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from oracle import analytic_pictures, closed_forms, screen_space
from oracle.analytic_pictures import Plane, Sphere
from passes.estimator_cases import (
    ball_on_floor,
    corner,
    covered_texels,
    picture_frame,
    positions,
    random_picture,
    run_on,
    tilted_plane,
    twin_of,
)
from passes.pass_harness import make_frame, make_scene, quad, run_pass

from ssdo_gl.gpu.geometry import Geometry
from ssdo_gl.graph.settings import SettingError
from ssdo_gl.passes.gbuffer import GBufferPass
from ssdo_gl.passes.ssao import SsaoPass, SsaoSettings
from ssdo_gl.scene.camera import Camera

SIZE = (48, 36)
TAN_Y = 0.5
POINT_ESTIMATORS = ("hemisphere", "rgs09")
ESTIMATORS = ("march", *POINT_ESTIMATORS)

# Both sides add the same float32 shares; N of them, each within an ulp of 1.
SUM_TOLERANCE = 4e-7
# Share of pixels in which some comparison is a near tie that float32 may decide otherwise.
UNSURE_SHARE = 0.03


def visibility(gl, shaders, picture, settings, frame=None, has_back=None):
    has_back = picture.z_back is not None if has_back is None else has_back
    size = picture.z.shape[1], picture.z.shape[0]
    frame = frame or picture_frame(size, picture.tan_half_fov[1], near=picture.near)
    image = run_on(gl, shaders, SsaoPass(settings, has_back_layer=has_back), frame, picture)
    return image[..., 0]


def tan_half(size=SIZE, tan_y=TAN_Y):
    return tan_y * size[0] / size[1], tan_y


# --- against the float64 twin -------------------------------------------------------


@pytest.mark.parametrize("has_back", [False, True])
@pytest.mark.parametrize("radius", [0.4, 2.0, np.inf])
@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_matches_the_twin_on_noise(gl, shaders, estimator, radius, has_back):
    """Every texel a surface of its own: all tests of a sample decide, all the time."""
    settings = SsaoSettings(estimator=estimator, radius=radius, samples=24, steps=4)
    frame = picture_frame(SIZE, TAN_Y, seed=7)
    picture = random_picture(3, SIZE, frame.view.tan_half_fov, has_back)
    found = visibility(gl, shaders, picture, settings, frame)
    texel = covered_texels(picture)
    samples = screen_space.sample(picture, texel, texel, twin_of(settings, frame, has_back))
    sure = ~samples.unsure.any(1)
    assert sure.mean() > 1.0 - UNSURE_SHARE
    expected = screen_space.visibility(samples)
    np.testing.assert_allclose(
        found[texel[:, 1], texel[:, 0]][sure], expected[sure], rtol=0.0, atol=SUM_TOLERANCE
    )


@pytest.mark.parametrize("growth, front, back", [(0.0, 0.0, 0.0), (1.0, 1.5, 0.5)])
def test_matches_the_twin_for_other_steps(gl, shaders, growth, front, back):
    settings = SsaoSettings(
        estimator="march",
        radius=1.0,
        samples=30,
        steps=5,
        step_growth=growth,
        front_slack=front,
        back_slack=back,
    )
    frame = picture_frame(SIZE, TAN_Y)
    picture = random_picture(4, SIZE, frame.view.tan_half_fov, True)
    found = visibility(gl, shaders, picture, settings, frame)
    texel = covered_texels(picture)
    samples = screen_space.sample(picture, texel, texel, twin_of(settings, frame, True))
    sure = ~samples.unsure.any(1)
    np.testing.assert_allclose(
        found[texel[:, 1], texel[:, 0]][sure],
        screen_space.visibility(samples)[sure],
        rtol=0.0,
        atol=SUM_TOLERANCE,
    )


def test_half_resolution_uses_every_second_texel(gl, shaders):
    """Receivers are full-resolution texels, and so is everything that they look at."""
    size = (49, 35)
    settings = SsaoSettings(
        estimator="march", radius=1.0, samples=16, steps=4, resolution_scale=0.5
    )
    frame = picture_frame(size, TAN_Y)
    picture = random_picture(5, size, frame.view.tan_half_fov, False)
    found = visibility(gl, shaders, picture, settings, frame)
    assert found.shape == (18, 25)
    y, x = np.nonzero(picture.z[::2, ::2] > 0.0)
    pixel = np.stack([x, y], 1)
    samples = screen_space.sample(picture, 2 * pixel, pixel, twin_of(settings, frame))
    sure = ~samples.unsure.any(1)
    np.testing.assert_allclose(
        found[y, x][sure], screen_space.visibility(samples)[sure], atol=SUM_TOLERANCE
    )


# --- closed forms -------------------------------------------------------------------

CORNER_SIZE = (160, 96)
CORNER_TAN = 0.25
CORNER_RADIUS = 0.4
# 16 sets of 64 directions (256 for points) look at each distance; what is left is their
# error, and that of texels of 0.04 R, which decide to within half of one. Measured .006.
CORNER_TOLERANCE = 0.011


def corner_occlusion(gl, shaders, settings):
    """Return k = d / R and occlusion, means over blocks of 4 rows of the floor."""
    frame = picture_frame(CORNER_SIZE, CORNER_TAN)
    picture = corner(CORNER_SIZE, frame.view.tan_half_fov)
    found = visibility(gl, shaders, picture, settings, frame)
    rows = np.arange(24, 48)
    # Columns whose rays stay in the frame.
    occlusion = 1.0 - found[rows][:, 48:112].mean(1)
    d = np.linalg.norm(positions(picture)[rows, 80] - [0.0, 0.0, -3.0], axis=1)
    return d / CORNER_RADIUS, occlusion


def mean_of_rows(values):
    return np.asarray(values).reshape(-1, 4).mean(1)


@pytest.mark.parametrize("steps", [1, 2, 8])
def test_march_finds_a_corner_s_true_occlusion(gl, shaders, steps):
    """A1, for any number of steps: the last one stands at R. Ending anywhere in its
    stratum instead, 8 equal steps would find .164 where .183 is true."""
    settings = SsaoSettings(
        estimator="march",
        radius=CORNER_RADIUS,
        samples=64 * steps,
        steps=steps,
        thickness=np.inf,
        front_slack=0.0,
    )
    k, occlusion = corner_occlusion(gl, shaders, settings)
    expected = np.where(k < 1.0, closed_forms.corner_occlusion(k), 0.0)
    np.testing.assert_allclose(
        mean_of_rows(occlusion), mean_of_rows(expected), atol=CORNER_TOLERANCE
    )


def test_front_slack_darkens_a_corner_by_little(gl, shaders):
    """What thin things gain, corners pay: the default of 1/4 stride, at 8 steps."""
    settings = SsaoSettings(
        estimator="march", radius=CORNER_RADIUS, samples=512, steps=8, thickness=np.inf
    )
    k, occlusion = corner_occlusion(gl, shaders, settings)
    excess = occlusion - np.where(k < 1.0, closed_forms.corner_occlusion(k), 0.0)
    assert np.all(np.abs(mean_of_rows(excess)) < 0.025)


def test_rgs09_finds_its_own_expectation_in_a_corner(gl, shaders):
    """A3: the paper's estimator is biased by a known amount, and ours by just that."""
    settings = SsaoSettings(estimator="rgs09", radius=CORNER_RADIUS, samples=256)
    k, occlusion = corner_occlusion(gl, shaders, settings)
    expected = np.where(k < 1.0, closed_forms.corner_occlusion_rgs09(np.minimum(k, 1.0)), 0.0)
    np.testing.assert_allclose(
        mean_of_rows(occlusion), mean_of_rows(expected), atol=CORNER_TOLERANCE
    )
    # It must not find the truth by a mistake of ours.
    assert closed_forms.corner_occlusion(k[14]) - expected[14] > 5 * CORNER_TOLERANCE


def test_hemisphere_finds_its_own_expectation_in_a_corner(gl, shaders):
    """A4 with distances R sqrt(u)."""
    settings = SsaoSettings(
        estimator="hemisphere", radius=CORNER_RADIUS, samples=256, thickness=np.inf
    )
    k, occlusion = corner_occlusion(gl, shaders, settings)
    expected = [
        closed_forms.corner_occlusion_of_points(q, lambda x: 1.0 - x * x) if q < 1.0 else 0.0
        for q in k
    ]
    np.testing.assert_allclose(
        mean_of_rows(occlusion), mean_of_rows(expected), atol=CORNER_TOLERANCE
    )


def test_march_in_a_box_corner(gl, shaders):
    """B: three walls; the camera looks into the corner along the room's diagonal."""
    size, radius = (200, 200), 0.5
    frame = picture_frame(size, 0.2)
    axes = np.array([[1, 1, 1], [-1, 1, 0], [-1, -1, 2]], float)
    axes = axes / np.linalg.norm(axes, axis=1, keepdims=True)
    # Rows: the room's x, y, z seen from the camera, which looks along -(1, 1, 1).
    walls = np.stack([axes[1], axes[2], axes[0]], 1)
    corner_vs = np.array([0.0, 0.0, -4.0])
    picture = analytic_pictures.cast(
        [Plane(corner_vs, n) for n in walls], size, frame.view.tan_half_fov
    )
    settings = SsaoSettings(
        estimator="march",
        radius=radius,
        samples=512,
        steps=8,
        thickness=np.inf,
        front_slack=0.0,
    )
    found = visibility(gl, shaders, picture, settings, frame)
    room = (positions(picture) - corner_vs) @ walls.T
    # Points of the floor (third wall), in blocks around given distances from the others.
    for k1, k2 in ((0.2, 0.5), (0.6, 0.6), (0.3, 1.2)):
        away = np.abs(room - [k1 * radius, k2 * radius, 0.0]).max(-1)
        near = away < 0.035 * radius
        assert near.sum() >= 8
        expected = closed_forms.box_corner_occlusion(k1, min(k2, 1.0))
        # Within the block k varies by .035, occlusion by up to twice the corner's bound.
        assert 1.0 - found[near].mean() == pytest.approx(expected, abs=2 * CORNER_TOLERANCE)


def test_ball_on_the_floor_with_its_back(gl, shaders):
    """E1, for points between the camera and the ball, which see its visible side."""
    size = (160, 120)
    frame = picture_frame(size, 0.25)
    picture = ball_on_floor(size, frame.view.tan_half_fov)
    settings = SsaoSettings(estimator="march", radius=2.0, samples=32 * 16, steps=16)
    found = visibility(gl, shaders, picture, settings, frame)
    c = np.sqrt(0.5)
    toward_camera = np.array([0.0, -c, c])
    local = positions(picture) - [0.0, 0.0, -4.0]
    strip = (np.abs(local @ [0.0, c, c]) < 1e-3) & (np.abs(local[..., 0]) < 0.1)
    for rho in (0.6, 0.8, 1.0):
        near = strip & (np.abs(local @ toward_camera - rho) < 0.05)
        assert near.sum() > 20
        expected = closed_forms.sphere_on_plane_occlusion(rho, 0.5)
        # The far half of the ball is hidden; the back layer stands in for it. Measured
        # errors up to .02, without the layer up to .2.
        assert 1.0 - found[near].mean() == pytest.approx(float(expected), abs=0.03)


# --- invariants ---------------------------------------------------------------------


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
@pytest.mark.parametrize("degrees", [0.0, 45.0, 75.0, 85.0, 89.0, 89.9])
def test_open_plane_is_exactly_open(gl, shaders, degrees, scale, estimator):
    size = (64, 48)
    frame = picture_frame(size, TAN_Y, near=0.01 * scale)
    picture = tilted_plane(degrees, size, frame.view.tan_half_fov, scale)
    for radius in (0.2, 3.0, np.inf):
        settings = SsaoSettings(estimator=estimator, radius=radius * scale, samples=64)
        assert np.all(visibility(gl, shaders, picture, settings, frame) == 1.0)


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
    assert np.all(visibility(gl, shaders, ball, settings, frame) == 1.0)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_power_of_two_scale_changes_nothing(gl, shaders, estimator):
    """Lengths scaled by 2^k scale every float exactly: the images must be equal."""
    frame = picture_frame(SIZE, TAN_Y)
    picture = random_picture(6, SIZE, frame.view.tan_half_fov, True)
    settings = SsaoSettings(estimator=estimator, radius=1.0, samples=32)
    reference = visibility(gl, shaders, picture, settings, frame)
    for scale in (2.0**-10, 2.0**13):
        scaled = dataclasses.replace(
            picture, z=picture.z * scale, z_back=picture.z_back * scale, near=picture.near * scale
        )
        found = visibility(
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


@pytest.mark.parametrize("estimator", ["march"])
def test_larger_radius_never_brightens(gl, shaders, estimator):
    frame = picture_frame(CORNER_SIZE, CORNER_TAN)
    for picture in (
        corner(CORNER_SIZE, frame.view.tan_half_fov),
        ball_on_floor(CORNER_SIZE, frame.view.tan_half_fov),
    ):
        means = []
        for radius in (0.05, 0.1, 0.2, 0.4, 0.8, 1.6, np.inf):
            settings = SsaoSettings(estimator=estimator, radius=radius, samples=128)
            means.append(visibility(gl, shaders, picture, settings, frame).mean())
        assert np.all(np.diff(means) < MEAN_TOLERANCE)
        assert means[-1] < means[0] - 0.01


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_mirrored_picture_gives_the_mirrored_image(gl, shaders, estimator):
    """On average over blocks: the sample pattern itself is not symmetric."""
    frame = picture_frame(CORNER_SIZE, CORNER_TAN)
    picture = ball_on_floor(CORNER_SIZE, frame.view.tan_half_fov)
    settings = SsaoSettings(estimator=estimator, radius=0.6, samples=256)
    found = visibility(gl, shaders, picture, settings, frame)
    blocks = found.reshape(24, 4, 40, 4).mean((1, 3))
    # One block in which a silhouette falls differently may differ; not their mean.
    assert np.abs(blocks - blocks[:, ::-1]).mean() < 3 * MEAN_TOLERANCE


@pytest.mark.parametrize("estimator", [*ESTIMATORS, "zbuffer"])
def test_sky_is_open_and_blocks_nothing(gl, shaders, estimator):
    frame = picture_frame(SIZE, TAN_Y)
    empty = analytic_pictures.cast([], SIZE, frame.view.tan_half_fov)
    settings = SsaoSettings(estimator=estimator, radius=1.0)
    assert np.all(visibility(gl, shaders, empty, settings, frame) == 1.0)
    # A disc of floor in the middle of nothing.
    picture = tilted_plane(30.0, SIZE, frame.view.tan_half_fov)
    far = np.linalg.norm(positions(picture) - [0, 0, -3], axis=-1) > 0.5
    island = dataclasses.replace(picture, z=np.where(far, 0.0, picture.z))
    if estimator != "zbuffer":
        assert np.all(visibility(gl, shaders, island, settings, frame) == 1.0)


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("radius", [0.0, 1e-30, 0.02])
def test_radius_below_a_pixel_is_open(gl, shaders, estimator, radius):
    """At depth 3 a pixel of this frame covers 0.08."""
    frame = picture_frame(SIZE, TAN_Y)
    picture = corner(SIZE, frame.view.tan_half_fov)
    settings = SsaoSettings(estimator=estimator, radius=radius)
    assert np.all(visibility(gl, shaders, picture, settings, frame) == 1.0)


def test_radius_of_exactly_a_pixel_is_the_limit(gl, shaders):
    """A pixel covers z / 36 here, so a radius of .06 is below a pixel from depth 2.16 on."""
    frame = picture_frame(SIZE, TAN_Y)
    picture = random_picture(9, SIZE, frame.view.tan_half_fov, False)
    settings = SsaoSettings(estimator="march", radius=0.06, samples=64, thickness=np.inf)
    found = visibility(gl, shaders, picture, settings, frame)
    assert np.all(found[picture.z > 2.161] == 1.0)
    assert found[(picture.z > 0.0) & (picture.z < 2.159)].min() < 1.0


@pytest.mark.parametrize("estimator", [*ESTIMATORS, "zbuffer"])
@pytest.mark.parametrize("samples, steps", [(1, 1), (1, 8), (5, 2), (64, 64)])
def test_any_sample_count_stays_in_range(gl, shaders, estimator, samples, steps):
    frame = picture_frame(SIZE, TAN_Y)
    picture = random_picture(8, SIZE, frame.view.tan_half_fov, True)
    settings = SsaoSettings(estimator=estimator, radius=1.0, samples=samples, steps=steps)
    found = visibility(gl, shaders, picture, settings, frame)
    assert np.all((found >= 0.0) & (found <= 1.0))
    assert found.min() < 1.0


def test_thin_pole_needs_the_back_layer(gl, shaders):
    """A pole far before a wall: within R of the wall seen from the camera, but its back
    is not. Without the layer the wall darkens as if the pole reached it."""
    frame = picture_frame(CORNER_SIZE, CORNER_TAN)
    surfaces = [Plane((0, 0, -5), (0, 0, 1)), Sphere((0, 0, -3), 0.1)]
    picture = analytic_pictures.cast(surfaces, CORNER_SIZE, frame.view.tan_half_fov)
    settings = SsaoSettings(estimator="march", radius=1.0, samples=128, thickness=3.0)
    with_back = visibility(gl, shaders, picture, settings, frame)
    without = visibility(gl, shaders, picture, settings, frame, has_back=False)
    wall = picture.z > 4.0
    assert np.all(with_back[wall] == 1.0)
    assert without[wall].min() < 0.9


def test_seed_decides_the_pattern(gl, shaders):
    frame = picture_frame(SIZE, TAN_Y)
    picture = corner(SIZE, frame.view.tan_half_fov)
    settings = SsaoSettings(radius=0.5, samples=4)
    images = [
        visibility(gl, shaders, picture, settings, picture_frame(SIZE, TAN_Y, seed=seed))
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
    found = visibility(gl, shaders, step, settings, frame)
    assert np.all(found[:, :24] == 1.0)
    assert np.all(found[:, 24 + 7 :] == 1.0)
    # The first far column sees 6 of its box's 13 columns nearer; the pattern's error is
    # that of 64 samples.
    assert found[:, 24].mean() == pytest.approx(1.0 - 6.0 / 13.0, abs=0.04)


def test_settings_are_checked():
    with pytest.raises(SettingError, match=r"resolution_scale = 0\.7: must be 0\.5 or 1"):
        SsaoPass(SsaoSettings(resolution_scale=0.7)).settings.receiver_stride  # noqa: B018
    settings = SsaoSettings(estimator="march", samples=20, steps=8)
    assert (settings.direction_count, settings.step_count) == (2, 8)
    settings = SsaoSettings(estimator="march", samples=4, steps=8)
    assert (settings.direction_count, settings.step_count) == (1, 4)
    settings = SsaoSettings(estimator="hemisphere", samples=20, steps=8)
    assert (settings.direction_count, settings.step_count) == (20, 1)
