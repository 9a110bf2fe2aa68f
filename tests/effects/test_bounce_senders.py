"""What sends the bounce, and what does not: sides, faults, bounds."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from effects.bounce_harness import CORNER_RADIUS, ESTIMATORS, colors, ones, run, the_corner
from oracle import screen_space
from passes.estimator_cases import (
    SUM_TOLERANCE,
    noise,
    picture_frame,
    run_on,
)

from ssdo_gl.effects.bounce import BouncePass, BounceSettings
from ssdo_gl.effects.directional import DirectionalPass, DirectionalSettings
from ssdo_gl.scene.environment.environment_kinds import ConstantEnvironment


def slab_above_floor():
    """A floor, and the top of a slab that hovers over its middle, seen from above.

    The floor's receivers beside the slab are blocked by it, but what the camera sees is
    its top, which faces away from them.
    """
    frame = picture_frame((64, 64), 0.5)
    tan_half = frame.view.tan_half_fov
    inside = np.zeros((64, 64), bool)
    inside[20:44, 20:44] = True
    normal = np.broadcast_to([0.0, 0.0, 1.0], (64, 64, 3))
    z = np.where(inside, 2.5, 3.0)
    back = np.where(inside, 2.6, 0.0)
    return screen_space.Picture(z, normal, normal, tan_half, 0.01, back), inside


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_sender_that_faces_away_gives_nothing(gl, shaders, estimator):
    """The sign of the sender's cosine: with the wrong one, only these would send."""
    picture, inside = slab_above_floor()
    settings = BounceSettings(
        estimator=estimator, radius=1.0, samples=128, steps=8, hidden_senders=0.0
    )
    image = run(gl, shaders, picture, settings, ones(picture), has_back=True)
    assert np.all(image[..., :3] == 0.0)
    # They do block: the furnace's other half is missing.
    frame = picture_frame((64, 64), 0.5, environment=ConstantEnvironment((1.0,) * 3))
    sky = DirectionalSettings(estimator=estimator, radius=1.0, samples=128, steps=8)
    directional = DirectionalPass(sky, environment="constant", has_back_layer=True)
    assert run_on(gl, shaders, directional, frame, picture)[~inside, 3].min() < 0.95


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_sender_that_faces_the_receiver_gives_light(gl, shaders, estimator):
    picture = the_corner()
    settings = BounceSettings(estimator=estimator, radius=CORNER_RADIUS)
    assert run(gl, shaders, picture, settings, ones(picture))[46:50, 48:112, 0].mean() > 0.3


def test_hidden_senders_may_be_given_a_share(gl, shaders):
    picture, inside = slab_above_floor()
    settings = BounceSettings(radius=1.0, samples=128, steps=8, hidden_senders=1.0)
    image = run(gl, shaders, picture, settings, ones(picture), has_back=True)
    assert image[~inside, 0].max() > 0.1
    half = dataclasses.replace(settings, hidden_senders=0.5)
    np.testing.assert_array_equal(
        run(gl, shaders, picture, half, ones(picture), has_back=True)[..., :3],
        0.5 * image[..., :3],
    )


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_sender_bound_keeps_the_hue(gl, shaders, estimator):
    picture = the_corner()
    settings = BounceSettings(estimator=estimator, radius=CORNER_RADIUS)
    bounded = run(gl, shaders, picture, settings, ones(picture, (8e5, 4e5, 1e5)), bound=2.0)
    expected = run(gl, shaders, picture, settings, ones(picture, (2.0, 1.0, 0.25)))
    np.testing.assert_allclose(bounded, expected, rtol=SUM_TOLERANCE, atol=1e-7)


@pytest.mark.parametrize("radius", [0.0, 1e-30, np.inf])
@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_extreme_radii_stay_finite(gl, shaders, estimator, radius):
    settings = BounceSettings(estimator=estimator, radius=radius)
    image = run(gl, shaders, noise(), settings, colors(noise()))
    assert np.all(np.isfinite(image))
    assert np.all(image[..., :3] >= 0.0)
    if radius < 1.0:
        assert np.all(image[..., :3] == 0.0)


def test_depth_of_the_receiver_rides_along(gl, shaders):
    """For the filter, which then reads one texture less."""
    picture = noise()
    settings = BounceSettings(radius=0.8, resolution_scale=0.5)
    image = run(gl, shaders, picture, settings, colors(picture))
    np.testing.assert_array_equal(image[..., 3], picture.z[::2, ::2].astype(np.float32))


def test_adds_to_another_irradiance(gl, shaders):
    picture, settings = noise(), BounceSettings(radius=0.8, samples=24, steps=4, strength=0.5)
    size = picture.z.shape[1], picture.z.shape[0]
    frame = picture_frame(size, picture.tan_half_fov[1], near=picture.near)
    other = np.concatenate([colors(picture), np.full((*picture.z.shape, 1), np.nan)], -1)
    sent = np.concatenate([colors(picture, 5), np.ones((*picture.z.shape, 1))], -1)
    images = {"sender_radiance": sent, "other": other}
    alone = run_on(gl, shaders, BouncePass(settings), frame, picture, images)
    both = run_on(gl, shaders, BouncePass(settings, adds="other"), frame, picture, images)
    np.testing.assert_array_equal(both[..., 3], alone[..., 3])
    np.testing.assert_allclose(both[..., :3], alone[..., :3] + other[..., :3], rtol=SUM_TOLERANCE)
