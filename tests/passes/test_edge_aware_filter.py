"""The edge-aware filter: noise goes, edges stay, faults do not spread."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from passes.estimator_cases import (
    corner,
    inputs_of,
    picture_frame,
    positions,
    random_picture,
)
from passes.filter_harness import MEAN_TOLERANCE, SIZE, TAN_Y, halves, plane, run, tan_half
from passes.pass_harness import run_pass

from ssdo_gl.passes.edge_aware_filter import (
    EdgeAwareFilterPass,
    EdgeAwareFilterSettings,
    Signal,
)

FILTERS = ("edge", "naive", "none")


def pattern(size=SIZE, channels=4, seed=4):
    """An image that repeats every 4 x 4 pixels, in [0, 1]."""
    tile = np.random.default_rng(seed).random((4, 4, channels))
    return np.tile(tile, (size[1] // 4 + 1, size[0] // 4 + 1, 1))[: size[1], : size[0]], tile


@pytest.mark.parametrize("filter_name", FILTERS)
@pytest.mark.parametrize("visibility", [False, True])
def test_constant_stays_constant_on_any_surface(gl, shaders, filter_name, visibility):
    picture = random_picture(3, SIZE, tan_half(), False)
    raw = np.full((36, 48, 1 if visibility else 4), 0.625)
    image = run(
        gl,
        shaders,
        picture,
        raw,
        visibility=visibility,
        holds_z=visibility,
        filter=filter_name,
    )
    covered = picture.z > 0.0
    channels = 1 if visibility else 3
    np.testing.assert_allclose(image[covered][:, :channels], 0.625, rtol=MEAN_TOLERANCE)


@pytest.mark.parametrize("tap_radius", [2, 3, 4, 7])
@pytest.mark.parametrize("degrees", [0.0, 60.0, 80.0])
def test_interleaved_pattern_vanishes_on_a_plane(gl, shaders, degrees, tap_radius):
    """All 16 sample sets count alike, at any tilt: nothing but their mean is left."""
    raw, tile = pattern()
    picture = plane(degrees)
    image = run(gl, shaders, picture, raw, tap_radius=tap_radius)
    # Pixels with a full kernel on the plane, which ends at a horizon.
    reach = range(-tap_radius, tap_radius + 1)
    full = np.pad(picture.z > 0.0, tap_radius)
    full = np.all([np.roll(full, (i, j), (0, 1)) for i in reach for j in reach], axis=0)
    inner = image[full[tap_radius:-tap_radius, tap_radius:-tap_radius]][:, :3]
    assert len(inner) > 200
    # Depths rounded to float32 put coplanar taps off the plane by a little.
    np.testing.assert_allclose(
        inner, np.broadcast_to(tile.mean((0, 1))[:3], inner.shape), rtol=2e-4
    )


def test_naive_box_averages_4_by_4(gl, shaders):
    raw, tile = pattern()
    image = run(gl, shaders, plane(), raw, filter="naive")
    np.testing.assert_allclose(
        image[2:-2, 2:-2, :3], np.broadcast_to(tile.mean((0, 1))[:3], (32, 44, 3)), rtol=1e-5
    )


def test_none_copies(gl, shaders):
    raw, _ = pattern()
    image = run(gl, shaders, plane(), raw, filter="none")
    np.testing.assert_array_equal(image, raw.astype(np.float32))
    small, _ = pattern((24, 18))
    image = run(gl, shaders, plane(), small, filter="none")
    np.testing.assert_array_equal(image, small.repeat(2, 0).repeat(2, 1).astype(np.float32))


# A tap beyond a jump in depth of 30 pixels' footprints has weight 1e-7; 8 taps of 17.
LEAK_ACROSS_A_JUMP = 1e-6


# A tap on the other side of a right-angled crease: 1e-3 by its normal, and less by its
# distance from the plane; half of the weight of both stages together.
LEAK_ACROSS_A_CREASE = 2e-3


@pytest.mark.parametrize("visibility", [False, True])
@pytest.mark.parametrize("use_normals", [False, True])
def test_nothing_leaks_across_a_jump_in_depth(gl, shaders, use_normals, visibility):
    picture = dataclasses.replace(plane(), z=halves(2.0, 5.0, 1)[..., 0])
    raw = halves(0.0, 1.0, 1 if visibility else 4)
    image = run(
        gl,
        shaders,
        picture,
        raw,
        visibility=visibility,
        holds_z=visibility,
        use_normals=use_normals,
    )
    channels = 1 if visibility else 3
    assert np.abs(image[..., :channels] - raw[..., :channels]).max() < LEAK_ACROSS_A_JUMP


def test_little_leaks_across_a_crease(gl, shaders):
    size = (64, 64)
    picture = corner(size, tan_half(size))
    raw = np.broadcast_to(np.where(np.arange(64) < 32, 0.0, 1.0)[:, None, None], (64, 64, 4))
    image = run(gl, shaders, picture, raw)
    assert np.abs(image[..., :3] - raw[..., :3]).max() < LEAK_ACROSS_A_CREASE
    # It is the normals that tell the two apart near the crease.
    blind = run(gl, shaders, picture, raw, use_normals=False)
    assert np.abs(blind[..., :3] - raw[..., :3]).max() > 10 * LEAK_ACROSS_A_CREASE


@pytest.mark.parametrize("scale", [2.0**-10, 2.0**13])
def test_weights_know_no_unit_of_length(gl, shaders, scale):
    picture = random_picture(5, SIZE, tan_half(), False)
    raw, _ = pattern()
    scaled = dataclasses.replace(picture, z=picture.z * scale, near=picture.near * scale)
    np.testing.assert_array_equal(run(gl, shaders, scaled, raw), run(gl, shaders, picture, raw))


@pytest.mark.parametrize("scale", [1, 2])
@pytest.mark.parametrize("far_first", [False, True])
def test_tolerance_off_the_plane_counts_a_quarter(gl, shaders, scale, far_first):
    """The weight is (1 + x^2)^-2, x = distance from the plane / (tolerance * footprint).

    The footprint is that of the farther, on either side.
    """
    tolerance, far = 1.5, 3.0
    footprint = far * 2.0 * TAN_Y / SIZE[1] * scale
    left, right = (far, far - tolerance * footprint)[:: 1 if far_first else -1]
    step = np.where(np.arange(48) < 24, left, right)
    picture = dataclasses.replace(plane(), z=np.broadcast_to(step, (36, 48)))
    raw = halves(0.0, 1.0, 4, (48 // scale, 36 // scale))
    image = run(
        gl, shaders, picture, raw, scale=scale, depth_tolerance=tolerance, use_normals=False
    )
    # The receiver next to the edge: taps 1, 2, 3 of [1 2 3 4 3 2 1] lie beyond it.
    step = np.arange(-3.0, 4.0)
    weight = np.where(step > 0, 0.25, 1.0) * (4.0 - abs(step))
    slope = weight @ step / (weight @ step**2)
    weight *= 1.0 - step * np.clip(slope, -0.25, 0.25)
    expected = weight[step > 0].sum() / weight.sum()
    column = 23 if scale == 1 else 22
    # At half size the receiver's own column is copied but for the least weights of others.
    assert image[18, column, 0] == pytest.approx(expected, abs=2e-3)


def test_kernel_ends_at_the_frame_s_border(gl, shaders):
    """Taps outside do not count; clamped to the border they would count as its pixels."""
    raw = np.zeros((36, 48, 4))
    raw[:, 0] = 1.0
    image = run(gl, shaders, plane(), raw)
    # Those inside lie to one side, and count less by a quarter for each pixel.
    weights = np.array([4.0, 3.0, 2.0, 1.0]) * [1.0, 0.75, 0.5, 0.25]
    np.testing.assert_allclose(image[:, 0, 0], weights[0] / weights.sum(), rtol=1e-5)


# Pixels: how far away light is taken from, in the row at a joint and in the next, and what taps
# across it count. Without a line .8, 1 and 1.9 in the one, .3, .5 and 1.4 in the other.
OFF_IN_A_JOINT = {2: 0.545, 3: 0.667, 5: 1.351}
OFF_BESIDE_A_JOINT = {2: 0.0, 3: 0.111, 5: 0.706}
ACROSS_A_JOINT = 0.01


@pytest.mark.parametrize("holds_z", [False, True])
@pytest.mark.parametrize("tap_radius", [2, 3, 5])
def test_light_that_falls_off_towards_a_joint_does_so_still(gl, shaders, tap_radius, holds_z):
    """Beside a crease taps lie to one side: their mean is the light of farther away."""
    size = (64, 64)
    picture = corner(size, tan_half(size))
    ramp = 0.1 + np.abs(np.arange(64) - 31.5) / 32
    raw = np.broadcast_to(ramp[:, None, None], (64, 64, 3 if holds_z else 4))
    image = run(gl, shaders, picture, raw, tap_radius=tap_radius, holds_z=holds_z)
    off = 32 * (image[..., 0] - raw[..., 0])[8:-8, 8:-8]
    # Rows 31 and 32 meet in the crease.
    joint = np.isin(np.arange(64), (31, 32))[8:-8]
    assert np.abs(off[~joint]).max() < OFF_BESIDE_A_JOINT[tap_radius] + ACROSS_A_JOINT
    assert np.abs(off[joint]).max() < OFF_IN_A_JOINT[tap_radius] + ACROSS_A_JOINT


# How much too bright light that falls by half from pixel to pixel gets, on average, where these are
# five footprints and more apart in depth; without rays, whatever the depth.
OFF_IN_STEEP_LIGHT = 0.5
OFF_WITHOUT_RAYS = 0.758


def test_what_rays_find_far_away_along_a_surface_counts_less(gl, shaders):
    light = np.broadcast_to(0.5 ** np.arange(48.0)[:, None], (36, 48, 3))
    off = [
        (run(gl, shaders, plane(80.0), light, holds_z=True, has_rays=x)[..., :3] / light - 1.0)
        for x in (False, True)
    ]
    np.testing.assert_allclose(off[0][4:-4, 12:18], OFF_WITHOUT_RAYS, rtol=1e-3)
    assert off[1][4:-4, 12:18].mean() < OFF_IN_STEEP_LIGHT
    raw, _ = pattern(channels=3)
    upright = [run(gl, shaders, plane(), raw, holds_z=True, has_rays=x) for x in (False, True)]
    np.testing.assert_array_equal(*upright)


@pytest.mark.parametrize("spot", [(0, 0), (17, 23), (17, 24), (35, 47), (18, 2)])
def test_every_pixel_counts_more_than_nothing(gl, shaders, spot):
    picture = dataclasses.replace(plane(), z=halves(2.0, 5.0, 1)[..., 0])
    raw = np.zeros((36, 48, 4))
    raw[spot] = 1.0
    image = run(gl, shaders, picture, raw)
    assert image[spot][0] > 0.03
    assert np.all(image[..., :3] >= 0.0)


@pytest.mark.parametrize("scale", [1, 2])
def test_depth_beside_the_value_changes_nothing(gl, shaders, scale):
    """It saves a read: the depth is that of the receiver, through all stages."""
    picture = random_picture(6, SIZE, tan_half(), False)
    raw = np.random.default_rng(1).random((36 // scale, 48 // scale, 3))
    packed = run(gl, shaders, picture, raw, holds_z=True, scale=scale, depth_tolerance=20.0)
    alone = np.concatenate([raw, np.ones((*raw.shape[:2], 1))], -1)
    apart = run(gl, shaders, picture, alone, scale=scale, depth_tolerance=20.0)
    np.testing.assert_array_equal(packed[..., :3], apart[..., :3])
    visible = raw[..., :1]
    one = run(
        gl,
        shaders,
        picture,
        visible,
        visibility=True,
        holds_z=True,
        scale=scale,
        depth_tolerance=20.0,
    )
    # Where no receiver is near, neutral is 1 for visibility and 0 for light.
    known = (picture.z > 0.0) & (apart[..., 0] > 0.0)
    assert known.sum() > 1500
    np.testing.assert_allclose(one[known][:, 0], apart[known][:, 0], rtol=1e-6)


@pytest.mark.parametrize("filter_name", FILTERS)
@pytest.mark.parametrize("poison", [np.nan, np.inf, -np.inf, 1e30, -1.0])
@pytest.mark.parametrize("channel", [0, 2])
def test_a_faulty_texel_stays_where_it_is(gl, shaders, filter_name, poison, channel):
    raw, _ = pattern()
    raw = raw.copy()
    sound = run(gl, shaders, plane(), raw, filter=filter_name)
    raw[17, 23, channel] = poison
    image = run(gl, shaders, plane(), raw, filter=filter_name)
    assert np.all(np.isfinite(image))
    assert np.all((image[..., :3] >= 0.0) & (image[..., :3] <= 1.0))
    if filter_name == "none":
        assert np.count_nonzero(np.any(image[..., :3] != sound[..., :3], -1)) == 1
    else:
        # Its neighbours average one value less: of 16 or more, each at most 1 away.
        assert np.abs(image - sound)[..., :3].max() < 0.15


@pytest.mark.parametrize("poison", [np.nan, np.inf, 1.5, -0.5])
def test_a_faulty_visibility_stays_where_it_is(gl, shaders, poison):
    raw = np.full((36, 48, 1), 0.5)
    raw[17, 23] = poison
    image = run(gl, shaders, plane(), raw, visibility=True, holds_z=True)
    np.testing.assert_allclose(image, 0.5, rtol=MEAN_TOLERANCE)


@pytest.mark.parametrize("filter_name", FILTERS)
@pytest.mark.parametrize("scale", [1, 2])
def test_background_is_neutral_and_does_not_enter(gl, shaders, filter_name, scale):
    """Its values may be anything: no tap takes them, and none of them comes out."""
    sky = np.zeros((36, 48), bool)
    sky[10:20, 8:30] = True
    picture = dataclasses.replace(plane(), z=np.where(sky, 0.0, 3.0))
    raw = np.where(sky[::scale, ::scale, None], 0.9, 0.25) * np.ones(4)
    light = run(gl, shaders, picture, raw, filter=filter_name, scale=scale)
    assert np.all(light[sky][:, :3] == 0.0)
    if (filter_name, scale) != ("none", 2):
        np.testing.assert_allclose(light[~sky][:, :3], 0.25, rtol=MEAN_TOLERANCE)
    visibility = run(
        gl,
        shaders,
        picture,
        raw[..., :1],
        visibility=True,
        holds_z=True,
        filter=filter_name,
        scale=scale,
    )
    assert np.all(visibility[sky] == 1.0)


def test_smooths_real_noise_without_moving_its_mean(gl, shaders):
    """White noise on a plane: the variance falls to about that of 25 and more taps."""
    raw = np.random.default_rng(9).random((36, 48, 4))
    image = run(gl, shaders, plane(30.0), raw)[8:-8, 8:-8, 0]
    source = raw[8:-8, 8:-8, 0]
    # sum of squares of the separable kernel [1 2 3 4 3 2 1] / 16, along both axes.
    share = (44.0 / 256.0) ** 2
    assert image.var() < 1.6 * share * source.var()
    assert image.mean() == pytest.approx(source.mean(), abs=0.02)


def test_positions_are_what_the_weights_see():
    """The corner's crease runs through the middle row: the tests above rely on it."""
    z = positions(corner((64, 64), tan_half((64, 64))))[..., 1]
    assert np.all(z[:32] < 0.0)
    assert np.all(z[32:] > 0.0)


@pytest.mark.parametrize("name", FILTERS)
@pytest.mark.parametrize("scale", [1, 2])
@pytest.mark.parametrize("holding", [(False, False), (False, True), (True, False), (True, True)])
def test_two_images_in_one_pass_are_as_in_two(gl, shaders, name, scale, holding):
    """Also around a value of one of them that is no number."""
    picture = dataclasses.replace(plane(60.0), z=plane(60.0).z.copy())
    picture.z[:10, 20:] *= 2.0
    picture.z[20:30, :9] = 0.0
    shape = (SIZE[1] // scale, SIZE[0] // scale)
    raws = [np.random.default_rng(seed).uniform(0.0, 1.0, (*shape, 4)) for seed in (1, 2)]
    raws[1][5, 6, 1] = np.nan
    for raw, holds_z in zip(raws, holding, strict=True):
        if holds_z:
            # Pixel p of a half-size image sits on texel 2 p, counted from the bottom.
            raw[..., 3] = picture.z[::scale, ::scale][::-1]
    images = inputs_of(picture)
    inputs = {
        "a": raws[0],
        "b": raws[1],
        "z_vs": images["z_vs"],
        "normals_vs": images["normals_vs"],
    }
    signals = [Signal(n, f"{n}{n}", holds_z=h) for n, h in zip("ab", holding, strict=True)]
    settings = EdgeAwareFilterSettings(filter=name)
    frame = picture_frame(SIZE, TAN_Y)
    both = EdgeAwareFilterPass("filter", settings, *signals)
    assert both.settings_key() != EdgeAwareFilterPass("filter", settings, signals[0]).settings_key()
    joint = run_pass(gl, shaders, both, frame, inputs)
    for signal in signals:
        one = EdgeAwareFilterPass("filter", settings, signal)
        alone = run_pass(gl, shaders, one, frame, {k: inputs[k] for k in one.reads})
        expected = alone[signal.result]
        assert np.ptp(expected) > 0.3
        channels = 3 if signal.holds_z else 4
        np.testing.assert_allclose(
            joint[signal.result][..., :channels], expected[..., :channels], atol=MEAN_TOLERANCE
        )


@pytest.mark.parametrize("name", FILTERS)
def test_a_share_of_an_image_is_multiplied_once_it_is_filtered(gl, shaders, name):
    """The image itself is not blurred: it holds what is known without noise."""
    rng = np.random.default_rng(3)
    images = inputs_of(plane())
    raw, factor = rng.uniform(0.0, 1.0, (2, SIZE[1], SIZE[0], 4))
    inputs = {"raw": raw, "z_vs": images["z_vs"], "normals_vs": images["normals_vs"]}
    settings = EdgeAwareFilterSettings(filter=name)
    one = EdgeAwareFilterPass("filter", settings, Signal("raw", "smooth"))
    other = EdgeAwareFilterPass("filter", settings, Signal("raw", "smooth"), factor="factor")
    assert one.settings_key() != other.settings_key()
    frame = picture_frame(SIZE, TAN_Y)
    alone = run_pass(gl, shaders, one, frame, inputs)["smooth"]
    times = run_pass(gl, shaders, other, frame, {**inputs, "factor": factor})["smooth"]
    np.testing.assert_allclose(
        times[..., :3], alone[..., :3] * factor[..., :3], atol=MEAN_TOLERANCE
    )
