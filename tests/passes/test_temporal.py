"""Averages over frames: the mean of what was seen of a surface, and of nothing else.

`passes/temporal.frag`, and `lib/past_surfaces.glsl`, which says what the last frame shows of it.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from gpu.image_texture import texture_from_image
from passes.estimator_cases import inputs_of, picture_frame, tilted_plane
from passes.pass_harness import STORED_AS

from ssdo_gl.gpu.geometry import Geometry
from ssdo_gl.gpu.texture import read_texture
from ssdo_gl.graph.render_pass import PassContext, TextureWithFacts
from ssdo_gl.passes.far_probes import ProbeRays
from ssdo_gl.passes.own_lookup import GATHERED, OwnRays
from ssdo_gl.passes.temporal import TemporalPass, TemporalSettings

SIZE = (24, 16)
TAN_Y = 0.5
Z = 3.0
# The width of a pixel of the plane before the camera.
PIXEL = 2.0 * Z * TAN_Y / SIZE[1]
# Means of ten float32.
ROUNDING = 1e-6
# Columns and rows of the picture, from its middle, row 0 at the top.
COLUMN, ROW = np.meshgrid(*(np.arange(n) - (n - 1) / 2.0 for n in SIZE))


class Frames:
    """Frames of a window that a pass sees, one after the other."""

    def __init__(
        self, gl, shaders, *, moves=True, unfiltered=None, lit_by="lights", own=None, **settings
    ):
        self.gl, self.shaders = gl, shaders
        self.own = own
        self.near = np.zeros((*SIZE[::-1], 4), np.float32)
        chosen, images = TemporalSettings(**settings), {"now": "average"}
        self.item = TemporalPass(
            "temporal", chosen, images, 1, unfiltered, lit_by, has_own_rays=own is not None
        )
        self.last: dict[str, TextureWithFacts] = {}
        self.count = 0
        self.moves = moves

    def show(self, image, *, x_px=0.0, z=Z, versions=None, raw=0.0, turn=0.0):
        """Return the average, row 0 at the top; the camera has moved `x_px` to the right.

        `turn`: of the shading normals' codes (2 across the square), from straight ahead.
        """
        self.count += 1
        still = picture_frame(SIZE, TAN_Y)
        view = dataclasses.replace(still.view, position_ws=np.array([x_px * PIXEL, 0.0, 0.0]))
        frame = dataclasses.replace(
            still,
            view=view,
            versions=versions or {},
            is_live=True,
            moves=self.count if self.moves else 0,
        )
        picture = tilted_plane(0.0, SIZE, view.tan_half_fov)
        image = np.asarray(image, np.float64)
        inputs = {**inputs_of(picture), "now": image, "raw": np.full_like(image, raw)}
        inputs[GATHERED[1]] = self.near
        inputs["z_vs"] = np.full_like(inputs["z_vs"], z)
        inputs["normals_vs"][..., 0] += 0.5 * turn
        textures = {
            name: texture_from_image(self.gl, inputs[name], STORED_AS.get(name, "f4"))
            for name in self.item.reads
        }
        geometry = Geometry(self.gl, frame.scene)
        facts = {GATHERED[1]: self.own}
        context = PassContext(
            *(self.gl, self.shaders, geometry, frame, textures, None),
            facts=facts,
            last=self.last,
        )
        self.last = dict(self.item.execute(context))
        geometry.release()
        return read_texture(self.last["average"].texture)


@pytest.fixture
def frames(gl, shaders):
    return Frames(gl, shaders)


def noise(seed):
    return np.random.default_rng(seed).uniform(0.0, 4.0, (SIZE[1], SIZE[0], 4)).astype(np.float32)


def linear(x_px):
    """Return what is linear along a plane, seen by a camera that has moved."""
    values = 10.0 + 0.25 * (COLUMN + x_px) + 0.5 * ROW
    return np.repeat(values[..., None], 4, -1)


def test_a_still_view_is_the_mean_of_its_frames(frames) -> None:
    for count in range(1, 11):
        found = frames.show(noise(count - 1))
        expected = np.mean([noise(i).astype(np.float64) for i in range(count)], 0)
        np.testing.assert_allclose(found, expected, atol=4.0 * ROUNDING)
    later = frames.show(noise(10))
    np.testing.assert_allclose(later, found + (noise(10) - found) / 10.0, atol=4.0 * ROUNDING)


def test_a_frame_that_stands_for_itself_is_handed_on(gl, shaders) -> None:
    frames = Frames(gl, shaders, moves=False)
    for number in range(3):
        np.testing.assert_array_equal(frames.show(noise(number)), noise(number))


def test_what_stands_still_for_a_while_does_not_end_an_average(frames) -> None:
    frames.show(noise(0))
    mean = frames.show(noise(1))
    frames.moves = False
    np.testing.assert_array_equal(frames.show(noise(2)), noise(2))
    frames.moves = True
    found = frames.show(noise(3))
    np.testing.assert_allclose(found, mean + (noise(3) - mean) / 3.0, atol=4.0 * ROUNDING)


PROBES = ProbeRays(0, 0)
# What a view at rest traces, and what it has traced.
TRACING = OwnRays(PROBES, "view")
TRACED = dataclasses.replace(TRACING, is_known=True)


def stopped(gl, shaders, count=3, **settings):
    """Return the average of frames in motion; their view has just come to rest."""
    frames = Frames(gl, shaders, own=TRACED, **settings)
    for number in range(count):
        mean = frames.show(noise(number))
    frames.moves, frames.own = False, TRACING
    return frames, mean


def test_an_average_stays_until_all_rays_of_pixels_own_are_traced(gl, shaders) -> None:
    frames, mean = stopped(gl, shaders)
    for number in range(3, 6):
        np.testing.assert_array_equal(frames.show(noise(number)), mean)
    frames.own = TRACED
    np.testing.assert_array_equal(frames.show(noise(6)), noise(6))


@pytest.mark.parametrize("changes", [{"x_px": 1.0}, {"versions": {"lights": 1}}], ids=str)
def test_an_average_does_not_stay_of_what_is_no_more(gl, shaders, changes) -> None:
    frames, _ = stopped(gl, shaders)
    np.testing.assert_array_equal(frames.show(noise(3), **changes), noise(3))


def test_an_average_beside_bodies_that_move_does_not_stay(gl, shaders) -> None:
    frames, _ = stopped(gl, shaders, 5)
    frames.moves = True
    frames.show(noise(5), versions={"geometry": 1})
    frames.moves = False
    np.testing.assert_array_equal(frames.show(noise(6), versions={"geometry": 1}), noise(6))


def test_motion_goes_on_from_a_view_whose_rays_are_traced(gl, shaders) -> None:
    """These show the first one of the offsets, which counts for ten frames."""
    frames, _ = stopped(gl, shaders)
    frames.own = TRACED
    for number in range(4, 7):
        np.testing.assert_array_equal(frames.show(noise(number)), noise(number))
    frames.moves = True
    expected = noise(4) + (noise(7) - noise(4)) / 11.0
    np.testing.assert_allclose(frames.show(noise(7)), expected, atol=4.0 * ROUNDING)


def test_pixels_that_trace_many_rays_are_averaged_over_six_frames(gl, shaders) -> None:
    frames = Frames(gl, shaders, own=TRACED, frames_of_rays=10)
    frames.near[:, :9, 3] = -1.0
    frames.near[:, 9:, 3] = 1.0
    most = np.where(frames.near[..., 3:] < 0.0, 6.0, 10.0)
    mean = np.zeros((*SIZE[::-1], 4))
    for number in range(1, 13):
        mean += (noise(number) - mean) / np.minimum(number, most)
        np.testing.assert_allclose(frames.show(noise(number)), mean, atol=1e-5)


@pytest.mark.parametrize("has_rays", [True, False])
def test_the_camera_alone_moves_over_more_frames_of_rays(gl, shaders, has_rays) -> None:
    own = TRACED if has_rays else None
    frames = Frames(gl, shaders, own=own, frames=2, frames_of_rays=4)
    mean = np.zeros((*SIZE[::-1], 4))
    for number in range(1, 7):
        mean += (noise(number) - mean) / min(number, 4 if has_rays else 2)
        np.testing.assert_allclose(frames.show(noise(number)), mean, atol=1e-5)


@pytest.mark.parametrize("has_rays", [True, False])
def test_what_is_known_on_one_side_alone_counts_for_its_share(gl, shaders, has_rays) -> None:
    """At the border a quarter of what is seen now lay within the frame before."""
    frames = Frames(gl, shaders, own=TRACED if has_rays else None)
    frames.show(noise(0))
    found = frames.show(noise(1), x_px=0.75)[:, -1]
    frames_before = 0.25 if has_rays else 1.0
    past, now = noise(0)[:, -1].astype(np.float64), noise(1)[:, -1]
    if has_rays:
        # Brought to the point by what the next pixel has more.
        change = 0.75 * (noise(1)[:, -2] - now)
        past[:, :3] = np.maximum(past - change, 0.0)[:, :3]
    expected = past + (now - past) / (1.0 + frames_before)
    np.testing.assert_allclose(found, expected, atol=1e-3)


@pytest.mark.parametrize("step", [0.375, -0.25])
def test_light_does_not_creep_on_from_what_is_known_on_one_side(gl, shaders, step) -> None:
    """At the border, where the past lies aside by the step, what is linear comes out as it is."""
    frames = Frames(gl, shaders, own=TRACED)
    for number in range(4):
        found = frames.show(linear(step * number), x_px=step * number)
        np.testing.assert_allclose(found[..., :3], linear(step * number)[..., :3], atol=1e-3)


@pytest.mark.parametrize(("px", "is_brought_back"), [(2.0, True), (8.0, False)])
def test_light_is_brought_back_beside_what_stands_close(gl, shaders, px, is_brought_back) -> None:
    """`px`: how many pixels before the plane stands what covers the right half."""
    frames = Frames(gl, shaders, own=TRACED)
    z = np.where(COLUMN > 0.0, Z - px * PIXEL, Z)[..., None]
    frames.show(linear(0.0), z=z)
    found = frames.show(linear(0.375), x_px=0.375, z=z)
    off = np.abs(found - linear(0.375))[2:-2, SIZE[0] // 2 - 1, :3]
    assert np.all(off < 1e-3) if is_brought_back else np.all(off > 0.02)


def test_a_fault_beside_does_not_enter_where_the_past_lies_aside(gl, shaders) -> None:
    frames = Frames(gl, shaders, own=TRACED)
    frames.show(linear(0.0))
    faulty = linear(0.375)
    faulty[:, -2] = np.nan
    assert np.isfinite(frames.show(faulty, x_px=0.375)[:, -1]).all()


@pytest.mark.parametrize(("turn", "share"), [(0.215, 0.75), (-0.344, 0.36), (0.44, 0.0)])
def test_what_faced_elsewhere_counts_the_less(gl, shaders, turn, share) -> None:
    """1 - (turn / .43)^2: of one surface all of it is known, but for fewer frames."""
    frames = Frames(gl, shaders, own=TRACED)
    frames.show(noise(0))
    past, now = noise(0).astype(np.float64), noise(1)
    expected = past + (now - past) / (1.0 + share)
    np.testing.assert_allclose(frames.show(now, turn=turn), expected, atol=1e-3)


@pytest.mark.parametrize("step", [1.0, 0.375, -2.25])
def test_a_pan_meets_the_same_places_again(frames, step) -> None:
    """Between texels, what is linear comes out as it is."""
    for number in range(3):
        found = frames.show(linear(step * number), x_px=step * number)
        # At the border one side of it is not known.
        inside = (slice(None), slice(6, -6))
        np.testing.assert_allclose(found[inside], linear(step * number)[inside], atol=1e-3)


def test_what_comes_into_view_has_no_past(frames) -> None:
    frames.show(noise(0))
    found = frames.show(noise(1), x_px=8.0)
    np.testing.assert_array_equal(found[:, -8:], noise(1)[:, -8:])
    assert not np.array_equal(found[:, 4:-9], noise(1)[:, 4:-9])


@pytest.mark.parametrize("z", [2.0, 4.0, Z - 0.4 * PIXEL, Z + 0.4 * PIXEL])
def test_another_surface_is_not_averaged(frames, z) -> None:
    frames.show(noise(0))
    np.testing.assert_array_equal(frames.show(noise(1), z=z), noise(1))


@pytest.mark.parametrize("z", [Z - 0.4 * PIXEL, Z + 0.4 * PIXEL])
def test_a_body_that_moves_is_averaged_with_where_it_was(frames, z) -> None:
    frames.show(noise(0), versions={"geometry": 1})
    found = frames.show(noise(1), z=z, versions={"geometry": 2})
    # In the middle, where no column of the picture is another's.
    expected = 0.5 * (noise(0).astype(np.float64) + noise(1))
    assert not np.array_equal(found, noise(1))
    np.testing.assert_allclose(found[7:9, 11:13], expected[7:9, 11:13], rtol=0.1)


def test_background_is_left_alone(frames) -> None:
    frames.show(noise(0), z=0.0)
    np.testing.assert_array_equal(frames.show(noise(1), z=0.0), noise(1))


@pytest.mark.parametrize("fault", [np.nan, np.inf, -np.inf])
def test_a_fault_ends_with_its_frame(gl, shaders, fault) -> None:
    sound, faulty = Frames(gl, shaders), Frames(gl, shaders)
    for number in range(5):
        image = noise(number)
        expected = sound.show(image, x_px=0.3 * number)
        if number == 1:
            image[5, 7] = fault
        found = faulty.show(image, x_px=0.3 * number)
        assert np.all(np.isfinite(found))
        if number < 2:
            # No other texel takes notice.
            touched = np.any(found != expected, axis=-1)
            assert touched.sum() == (number == 1)
        assert found.min() >= 0.0 and found.max() <= 4.0


def test_a_fault_leaves_the_past_as_it_was(frames) -> None:
    frames.show(noise(0))
    image = noise(1)
    image[5, 7] = np.nan
    np.testing.assert_array_equal(frames.show(image)[5, 7], noise(0)[5, 7])


def test_a_fault_without_a_past_is_no_light(frames) -> None:
    image = noise(0)
    image[3, 3] = np.nan
    found = frames.show(image)
    np.testing.assert_array_equal(found[3, 3], 0.0)


SHARE = 0.5


def test_long_averages_take_their_share_before_the_filter(gl, shaders) -> None:
    frames = Frames(gl, shaders, unfiltered=("now", "raw", SHARE))
    mean = 0.0
    for number in range(1, 15):
        count = min(number, 10)
        share = SHARE * min(max(count - 2, 0) / 5.0, 1.0)
        image = noise(number).astype(np.float64)
        mean += (image[..., :3] * (1.0 - share) + 7.0 * share - mean) / count
        found = frames.show(image, raw=7.0)
        np.testing.assert_allclose(found[..., :3], mean, atol=1e-5)


@pytest.mark.parametrize("fault", [np.nan, np.inf, -1.0])
def test_a_fault_before_the_filter_does_not_enter(gl, shaders, fault) -> None:
    plain = Frames(gl, shaders)
    frames = Frames(gl, shaders, unfiltered=("now", "raw", SHARE))
    for number in range(12):
        expected = plain.show(noise(number))
        found = frames.show(noise(number), raw=fault)
        np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("domain", ["lights", "environment"])
def test_light_that_changes_ends_the_past(frames, domain) -> None:
    """At once: nothing of it is left."""
    frames.show(noise(0))
    frames.show(noise(1))
    np.testing.assert_array_equal(frames.show(noise(2), versions={domain: 1}), noise(2))
    found = frames.show(noise(3), versions={domain: 1})
    np.testing.assert_allclose(found, (noise(2) + noise(3)) / 2.0, atol=ROUNDING)


def test_lights_that_an_animation_moves_shorten_the_past(gl, shaders) -> None:
    frames = Frames(gl, shaders, lit_by="light_sources")
    for number in range(9):
        mean = frames.show(noise(number))
    found = frames.show(noise(9), versions={"lights": 1})
    np.testing.assert_allclose(found, mean + (noise(9) - mean) / 3.0, atol=4.0 * ROUNDING)
    changed = {"lights": 2, "light_sources": 1}
    np.testing.assert_array_equal(frames.show(noise(10), versions=changed), noise(10))


def test_bodies_that_move_shorten_the_past(frames) -> None:
    for number in range(9):
        mean = frames.show(noise(number))
    found = frames.show(noise(9), versions={"geometry": 1})
    np.testing.assert_allclose(found, mean + (noise(9) - mean) / 3.0, atol=4.0 * ROUNDING)


def test_sharp_shadows_are_averaged_while_nothing_but_the_camera_moves(frames) -> None:
    frames.item.camera_alone = True
    for number in range(4):
        found = frames.show(noise(number))
    mean = np.mean([noise(number).astype(np.float64) for number in range(4)], 0)
    np.testing.assert_allclose(found, mean, atol=4.0 * ROUNDING)
    # Behind a body that moves its shadow would lag.
    np.testing.assert_array_equal(frames.show(noise(4), versions={"geometry": 1}), noise(4))
    found = frames.show(noise(5), versions={"geometry": 1})
    np.testing.assert_allclose(found, 0.5 * (noise(4) + noise(5)), atol=4.0 * ROUNDING)


def test_what_is_made_otherwise_is_not_averaged(frames) -> None:
    frames.show(noise(0))
    frames.item.made_from = 2
    np.testing.assert_array_equal(frames.show(noise(1)), noise(1))
