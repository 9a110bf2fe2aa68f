"""Light of per-pixel rays in motion, averaged over pixels in the same light, against float64.

`effects/moving_guide.frag`, and stage 4 of `lib/edge_aware_filter.glsl`.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from gpu.image_texture import texture_from_image
from passes.estimator_cases import inputs_of, picture_frame, tilted_plane
from passes.pass_harness import STORED_AS

from ssdo_gl.effects import moving_light
from ssdo_gl.effects.moving_light import TOLERANCE, averaged, guide_of
from ssdo_gl.effects.moving_rays import RayCounts, numbers_of_rays
from ssdo_gl.gpu.geometry import Geometry
from ssdo_gl.gpu.texture import read_texture
from ssdo_gl.graph.render_pass import PassContext

SIZE = (32, 24)
SHAPE = SIZE[1], SIZE[0]
TAN_Y = 0.5
Z = 3.0
# The width of a pixel of the plane before the camera.
PIXEL = 2.0 * Z * TAN_Y / SIZE[1]
ROUNDING = 1e-5
CONTACT, OTHER = -1.0, 1.0


class Motion:
    """A plane before a camera, and what is done to the light that pixels of it have gathered."""

    def __init__(self, gl, shaders, *, x_px=0.0):
        still = picture_frame(SIZE, TAN_Y)
        view = dataclasses.replace(still.view, position_ws=np.array([x_px * PIXEL, 0.0, 0.0]))
        frame = dataclasses.replace(still, view=view)
        images = inputs_of(tilted_plane(0.0, SIZE, view.tan_half_fov))
        self.gl = gl
        self.textures = {
            name: texture_from_image(gl, images[name], STORED_AS.get(name, "f4"))
            for name in ("z_vs", "normals_vs")
        }
        geometry = Geometry(gl, frame.scene)
        self.context = PassContext(gl, shaders, geometry, frame, self.textures, None)

    def guide(self, light, kinds, *, past=None, most_frames=16, stride=1):
        """Return what is known of `light` (h, w) after this frame, and that as (h, w, 2)."""
        image = np.stack([light, kinds], -1)
        light = texture_from_image(self.gl, image, "f4")
        _, known = numbers_of_rays(
            self.context, 1.0, RayCounts(2, 8, 16, 16, 0, False), stride, past
        )
        seen = guide_of(self.context, light, stride, known, most_frames)
        return seen, read_texture(seen.guide).astype(np.float64)

    def averaged(self, far, near, guide, kinds, *, stride=1):
        """Return the averages of light (h, w, 4) and (h, w, 3)."""
        depths = np.where(kinds == CONTACT, -Z, Z) * (kinds != 0.0)
        near = np.concatenate([near, depths[..., None]], -1)
        textures = (texture_from_image(self.gl, image, "f4") for image in (far, near, guide))
        return [read_texture(made) for made in averaged(self.context, *textures, stride)]


@pytest.fixture
def motion(gl, shaders):
    return Motion(gl, shaders)


def around(shape, step):
    """Yield for each of 3 x 3 taps its place, which pixels have it, and its distance squared."""
    rows, columns = np.mgrid[: shape[0], : shape[1]]
    for y in (-1, 0, 1):
        for x in (-1, 0, 1):
            v, u = rows + step * y, columns + step * x
            inside = (v >= 0) & (v < shape[0]) & (u >= 0) & (u < shape[1])
            place = np.clip(v, 0, shape[0] - 1), np.clip(u, 0, shape[1] - 1)
            yield place, inside, x * x + y * y


def guide_twin(light, kinds, step=1):
    """Return mean and its variance of five pixels of a kind, on a plane."""
    total, squares, weights = (np.zeros(light.shape) for _ in range(3))
    for place, inside, distance in around(light.shape, step):
        weight = inside & (kinds[place] == kinds) & (distance < 2)
        total += weight * light[place]
        squares += weight * light[place] ** 2
        weights += weight
    mean = total / weights
    with np.errstate(invalid="ignore", divide="ignore"):
        variance = (squares / weights - mean**2) / (weights - 1.0)
    variance = np.where(weights > 1.0, variance, light**2)
    return np.stack([mean, variance], -1) * (kinds != 0.0)[..., None]


def averaged_twin(values, guide, kinds, step):
    """Return averages of `values` (h, w, c), by how far their light is known to differ."""
    total, weights = np.zeros(values.shape), np.zeros(values.shape[:2])
    for place, inside, distance in around(values.shape[:2], step):
        noise = TOLERANCE * (guide[place][..., 1] + guide[..., 1]) + 1e-15
        beyond = np.maximum((guide[place][..., 0] - guide[..., 0]) ** 2 - noise, 0.0) / noise
        weight = 1.0 / (1.0 + beyond**2) / (1.0 + 0.25 * distance) ** 2
        # What traces as many rays; the rest counts next to nothing.
        weight = weight * np.where(kinds[place] == kinds, 1.0, 1e-3)
        weight = weight * inside * (kinds[place] != 0.0)
        total += weight[..., None] * values[place]
        weights += weight
    return total / weights[..., None]


@pytest.mark.parametrize("stride", [1, 2])
def test_the_guide_is_mean_and_variance_of_pixels_about(motion, stride):
    rng = np.random.default_rng(1)
    light, kinds = rng.random(SHAPE), rng.choice([CONTACT, OTHER, OTHER], SHAPE)
    kinds[5:8, 5:8] = CONTACT
    kinds[6, 6] = OTHER  # alone of its kind
    on = np.zeros(SHAPE, bool)
    on[-1::-stride, ::stride] = True
    kinds = kinds * on
    _, found = motion.guide(light, kinds, stride=stride)
    wanted = guide_twin(light, kinds, stride)
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=ROUNDING)
    assert stride > 1 or found[6, 6, 1] == pytest.approx(light[6, 6] ** 2)


def test_frames_of_a_still_view_are_averaged_up_to_the_limit(motion):
    rng, kinds = np.random.default_rng(2), np.full(SHAPE, OTHER)
    past, wanted = None, np.zeros((*SHAPE, 2))
    for number in range(1, 7):
        light = rng.random(SHAPE)
        past, found = motion.guide(light, kinds, past=past, most_frames=4)
        share = 1.0 / min(number, 4)
        mean, variance = np.moveaxis(guide_twin(light, kinds), -1, 0)
        kept = 1.0 - share
        wanted[..., 0] = kept * wanted[..., 0] + share * mean
        wanted[..., 1] = kept**2 * wanted[..., 1] + share**2 * variance
        np.testing.assert_allclose(found, wanted, rtol=0.0, atol=ROUNDING)


def test_what_was_known_of_a_place_is_found_where_it_is_now(gl, shaders):
    kinds = np.full(SHAPE, OTHER)
    ramp = np.tile(np.arange(SIZE[0], dtype=np.float64), (SIZE[1], 1))
    past, _ = Motion(gl, shaders).guide(ramp, kinds)
    seen, found = Motion(gl, shaders, x_px=3.0).guide(ramp + 3.0, kinds, past=past)
    inner = np.s_[2:-2, 2:-5]
    np.testing.assert_allclose(found[inner][..., 0], ramp[inner] + 3.0, atol=1e-3)
    frames = read_texture(seen.texture)[..., 1]
    # What comes into view was seen by no frame before.
    assert np.all(frames[:, :-4] == 2.0)
    assert np.all(frames[:, -2:] == 1.0)


@pytest.mark.parametrize("stride", [1, 2])
def test_light_is_averaged_as_by_the_twin(motion, stride):
    rng = np.random.default_rng(3)
    far, near = rng.random((*SHAPE, 4)), rng.random((*SHAPE, 3))
    kinds = rng.choice([CONTACT, OTHER], SHAPE)
    guide = np.stack([rng.random(SHAPE), rng.uniform(0.0, 0.1, SHAPE)], -1)
    found_far, found_near = motion.averaged(far, near, guide, kinds, stride=stride)
    (step,) = moving_light.STEPS
    for found, values in ((found_far, far), (found_near[..., :3], near)):
        wanted = averaged_twin(values, guide, kinds, step * stride)
        np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-4)
    # Whose rays these were is known to the next stage.
    np.testing.assert_array_equal(np.sign(found_near[..., 3]), kinds)


def test_levels_of_light_stay_apart_and_light_that_is_rare_is_not_lost(motion, monkeypatch):
    """Few pixels come upon a bright window: all of its light stays, spread over the others."""
    monkeypatch.setattr(moving_light, "STEPS", moving_light.UNEVEN_STEPS)
    rng, kinds = np.random.default_rng(4), np.full(SHAPE, OTHER)
    level = np.where(np.arange(SIZE[0]) < SIZE[0] // 2, 1.0, 4.0) * np.ones(SHAPE)
    past = None
    for _ in range(12):
        light = level * (rng.random(SHAPE) < 0.2) / 0.2
        past, guide = motion.guide(light, kinds, past=past)
    near = np.repeat(light[..., None], 3, -1)
    _, found = motion.averaged(np.zeros((*SHAPE, 4)), near, guide, kinds)
    assert found[..., 0].mean() == pytest.approx(light.mean(), rel=0.03)
    assert np.abs(found[..., 0] - level).mean() < 0.3 * np.abs(light - level).mean()
    left, right = found[:, : SIZE[0] // 2 - 2, 0].mean(), found[:, SIZE[0] // 2 + 2 :, 0].mean()
    assert (left, right) == pytest.approx((1.0, 4.0), rel=0.25)
