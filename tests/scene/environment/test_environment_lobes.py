"""The environment blurred by lobes, against sums over all of its texels."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.scene.environment.environment_kinds import (
    ConstantEnvironment,
    GradientEnvironment,
    MapEnvironment,
)
from ssdo_gl.scene.environment.environment_lobes import LEVEL_COUNT, lobe_gains, lobe_levels

# Texels of a map count as patches there and as points here; and the series is cut where the
# lobe has lost all but e^-8.
TOLERANCE = 0.02


def texel_directions(height, width):
    """Return directions (h, w, 3) of texels' centres, and their solid angles (h, w)."""
    polar = (np.arange(height) + 0.5) * np.pi / height
    azimuth = (np.arange(width) + 0.5) * 2.0 * np.pi / width - np.pi
    p, a = np.meshgrid(polar, azimuth, indexing="ij")
    directions = np.stack([np.sin(p) * np.sin(a), np.cos(p), -np.sin(p) * np.cos(a)], -1)
    half = 0.5 * np.pi / height
    return directions, (np.cos(p - half) - np.cos(p + half)) * 2.0 * np.pi / width


def blurred(image, direction, alpha):
    """The mean of an image over the lobe D(t / 2) cos(t) about a direction."""
    directions, angles = texel_directions(*image.shape[:2])
    cosine = directions @ direction
    half = 0.5 * np.arccos(np.clip(cosine, -1.0, 1.0))
    lobe = 1.0 / ((alpha * np.cos(half)) ** 2 + np.sin(half) ** 2) ** 2
    weight = lobe * np.maximum(cosine, 0.0) * angles
    return np.einsum("hw,hwc->c", weight, image) / weight.sum()


def test_a_constant_sky_stays_constant():
    for level in lobe_levels(ConstantEnvironment((1.0, 2.0, 3.0))):
        np.testing.assert_allclose(level, np.broadcast_to([1, 2, 3, 1], level.shape), rtol=1e-5)


@pytest.mark.parametrize("level", range(3, LEVEL_COUNT))
def test_levels_are_means_over_their_lobe(level):
    rng = np.random.default_rng(3)
    image = rng.uniform(0.0, 1.0, (64, 128, 3)).astype(np.float32)
    image[20, 30] = 300.0  # a sun
    environment = MapEnvironment(image)
    found = lobe_levels(environment)[level]
    directions, _ = texel_directions(*found.shape[:2])
    for row, column in ((len(found) // 3, found.shape[1] // 4), (1, 2), (len(found) // 2, -1)):
        wanted = blurred(environment.world_image(), directions[row, column], 2.0 ** (level - 6))
        np.testing.assert_allclose(found[row, column, :3], wanted, rtol=TOLERANCE)


def test_a_gradient_is_blurred_too():
    environment = GradientEnvironment((4.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 1.0))
    image = np.repeat(lobe_levels(environment)[0][..., :3], 1, axis=0)
    found = lobe_levels(environment)[5]
    directions, _ = texel_directions(*found.shape[:2])
    for row in range(len(found)):
        wanted = blurred(image, directions[row, 0], 0.5)
        np.testing.assert_allclose(found[row, 0, :3], wanted, atol=0.01 * wanted.max())


@pytest.mark.parametrize("alpha", [1.0 / 32.0, 0.25, 1.0])
def test_the_lobe_keeps_the_mean_and_blurs_the_more_the_wider_it_is(alpha):
    gains = lobe_gains(alpha, 64)
    assert gains[0] == pytest.approx(1.0)
    assert np.all(np.diff(gains[: int(2.0 / alpha)]) < 0.0)
    assert np.all(lobe_gains(0.5 * alpha, 64)[1:3] > gains[1:3])
