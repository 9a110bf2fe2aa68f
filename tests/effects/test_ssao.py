"""Visibility from the depth buffer: the float64 twin and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from oracle import analytic_pictures, closed_forms, screen_space
from oracle.analytic_pictures import Plane
from passes.estimator_cases import (
    ball_on_floor,
    corner,
    covered_texels,
    expected_visibility,
    picture_frame,
    positions,
    random_picture,
    run_visibility,
    twin_of,
)

from ssdo_gl.effects.ssao import SsaoSettings
from ssdo_gl.settings import estimators as registry

SIZE = (48, 36)
TAN_Y = 0.5
ESTIMATORS = tuple(registry.ESTIMATORS)

# Both sides add the same float32 shares; N of them, each within an ulp of 1.
SUM_TOLERANCE = 4e-7
# Horizons add the rounding of a square root, a polynomial and two cosines for each side.
ANGLE_TOLERANCE = 4e-6
TOLERANCE = dict.fromkeys(("bitmask", "gtao", "hbao", "sao"), ANGLE_TOLERANCE)
# Share of pixels in which some comparison is a near tie that float32 may decide otherwise.
UNSURE_SHARE = 0.03


# --- against the float64 twin -------------------------------------------------------


@pytest.mark.parametrize("has_back", [False, True])
@pytest.mark.parametrize("radius", [0.4, 2.0, np.inf])
@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_matches_the_twin_on_noise(gl, shaders, estimator, radius, has_back):
    """Every texel a surface of its own: all tests of a sample decide, all the time."""
    settings = SsaoSettings(estimator=estimator, radius=radius, samples=24, steps=4)
    frame = picture_frame(SIZE, TAN_Y, seed=7)
    picture = random_picture(3, SIZE, frame.view.tan_half_fov, has_back)
    found = run_visibility(gl, shaders, picture, settings, frame)
    texel = covered_texels(picture)
    expected, unsure = expected_visibility(
        picture, texel, texel, twin_of(settings, frame, has_back)
    )
    assert unsure.mean() < UNSURE_SHARE
    np.testing.assert_allclose(
        found[texel[:, 1], texel[:, 0]][~unsure],
        expected[~unsure],
        rtol=0.0,
        atol=TOLERANCE.get(estimator, SUM_TOLERANCE),
    )


# Compilers write loops of eight steps out, of sixteen they do not.
@pytest.mark.parametrize("steps", [5, 16])
@pytest.mark.parametrize("growth, front, back", [(0.0, 0.0, 0.0), (1.0, 1.5, 0.5)])
def test_matches_the_twin_for_other_steps(gl, shaders, growth, front, back, steps):
    settings = SsaoSettings(
        estimator="march",
        radius=1.0,
        samples=6 * steps,
        steps=steps,
        step_growth=growth,
        front_slack=front,
        back_slack=back,
    )
    frame = picture_frame(SIZE, TAN_Y)
    picture = random_picture(4, SIZE, frame.view.tan_half_fov, True)
    found = run_visibility(gl, shaders, picture, settings, frame)
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
    found = run_visibility(gl, shaders, picture, settings, frame)
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
    found = run_visibility(gl, shaders, picture, settings, frame)
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


def test_gtao_finds_a_corner_s_true_occlusion(gl, shaders):
    """A1: a wall has no back, so all below its horizon is blocked indeed."""
    settings = SsaoSettings(
        estimator="gtao", radius=CORNER_RADIUS, samples=32 * 2 * 24, steps=24, step_growth=0.0
    )
    k, occlusion = corner_occlusion(gl, shaders, settings)
    expected = np.where(k < 1.0, closed_forms.corner_occlusion(k), 0.0)
    np.testing.assert_allclose(
        mean_of_rows(occlusion), mean_of_rows(expected), atol=CORNER_TOLERANCE
    )


def test_hbao_finds_its_own_expectation_in_a_corner(gl, shaders):
    """Solid angles count alike, whatever their cosine: (1 - k) / 2."""
    settings = SsaoSettings(
        estimator="hbao", radius=CORNER_RADIUS, samples=64 * 24, steps=24, step_growth=0.0
    )
    k, occlusion = corner_occlusion(gl, shaders, settings)
    expected = 0.5 * np.maximum(1.0 - k, 0.0)
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
    # It must not be right by a mistake of ours.
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
    found = run_visibility(gl, shaders, picture, settings, frame)
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
    found = run_visibility(gl, shaders, picture, settings, frame)
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
