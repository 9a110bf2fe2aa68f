"""The filter tells levels of light apart as far as noise does: against float64, and by itself."""

from __future__ import annotations

import numpy as np
import pytest
from passes.estimator_cases import inputs_of, picture_frame
from passes.filter_harness import MEAN_TOLERANCE, SIZE, TAN_Y, plane
from passes.pass_harness import run_pass

from ssdo_gl.passes.edge_aware_filter import (
    EdgeAwareFilterPass,
    EdgeAwareFilterSettings,
    Levels,
    Signal,
)

SHAPE = SIZE[1], SIZE[0]
TOLERANCE = 4.0
UNKNOWN = 1e30
RADIUS = 3


def run(gl, shaders, values, light, variance, *, tolerance=TOLERANCE, **settings):
    """Filter images (h, w) side by side on a plane; all colours of one are alike."""
    signals = [Signal(f"raw_{i}", f"smooth_{i}") for i in range(len(values))]
    levels = None if light is None else Levels("light", tolerance)
    item = EdgeAwareFilterPass(
        "filter", EdgeAwareFilterSettings(**settings), *signals, levels=levels
    )
    images = inputs_of(plane())
    inputs = {name: images[name] for name in ("z_vs", "normals_vs")}
    inputs |= {f"raw_{i}": np.stack([v, v, v, np.ones(SHAPE)], -1) for i, v in enumerate(values)}
    if light is not None:
        inputs["light"] = np.stack([light, variance], -1)
    made = run_pass(gl, shaders, item, picture_frame(SIZE, TAN_Y), inputs)
    return [made[signal.result][..., 0] for signal in signals]


def twin(values, light, variance):
    """Return what the filter makes of images on a plane, in float64."""
    values = [np.asarray(v, np.float64) for v in values]
    for axis in (1, 0):
        length = light.shape[axis]
        sums = [np.zeros(light.shape) for _ in values]
        tilted = [np.zeros(light.shape) for _ in values]
        lights, variances, weights, first, second = (np.zeros(light.shape) for _ in range(5))
        for i in range(-RADIUS, RADIUS + 1):
            place = np.arange(length) + i
            inside = (place >= 0) & (place < length)
            place = np.clip(place, 0, length - 1)
            other, of_other = np.take(light, place, axis), np.take(variance, place, axis)
            x = (other - light) ** 2 / np.maximum(TOLERANCE * (variance + of_other), 1e-30)
            weight = min(4, RADIUS + 1 - abs(i)) / (1.0 + np.maximum(x - 1.0, 0.0) ** 2)
            weight = weight * (inside[None, :] if axis == 1 else inside[:, None])
            for total, tilt, value in zip(sums, tilted, values, strict=True):
                total += weight * np.take(value, place, axis)
                tilt += i * weight * np.take(value, place, axis)
            first += i * weight
            second += i * i * weight
            lights += weight * other
            variances += weight**2 * of_other
            weights += weight
        slope = np.clip(first / second, -1.0 / (RADIUS + 1), 1.0 / (RADIUS + 1))
        values = [
            (total - slope * tilt) / (weights - slope * first)
            for total, tilt in zip(sums, tilted, strict=True)
        ]
        light, variance = lights / weights, variances / weights**2
    return values


def slats(rng, noise):
    """Return rows of which every second is ten times as bright, their noise, and its variance."""
    level = np.where(np.arange(SHAPE[0]) % 2, 1.0, 0.1)[:, None] * np.ones(SHAPE)
    return level, level + noise * rng.normal(size=SHAPE), np.full(SHAPE, noise**2)


@pytest.mark.parametrize("count", [1, 2])
def test_weights_are_those_of_the_twin(gl, shaders, count):
    rng = np.random.default_rng(count)
    values = list(rng.uniform(0.0, 1.0, (count, *SHAPE)))
    light, variance = rng.uniform(0.0, 1.0, SHAPE), rng.uniform(0.0, 0.1, SHAPE)
    found = run(gl, shaders, values, light, variance)
    wanted = twin(values, light, variance)
    # Weights of differences of float32 over small variances.
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-4)
    assert np.abs(np.array(run(gl, shaders, values, None, None)) - wanted).max() > 0.05


def test_rows_of_other_light_do_not_mix_and_their_noise_goes(gl, shaders):
    level, noisy, variance = slats(np.random.default_rng(1), 0.05)
    (mixed,) = run(gl, shaders, [noisy], None, None)
    (kept,) = run(gl, shaders, [noisy], noisy, variance)
    assert np.abs(mixed - level).mean() > 0.4
    assert np.abs(kept - level).mean() < 0.6 * np.abs(noisy - level).mean()
    assert kept.mean() == pytest.approx(level.mean(), rel=0.01)


@pytest.mark.parametrize("told", [UNKNOWN, np.inf, np.nan])
def test_what_nothing_is_known_of_is_filtered_as_ever(gl, shaders, told):
    _, noisy, _ = slats(np.random.default_rng(2), 0.05)
    wanted = run(gl, shaders, [noisy], None, None)
    found = run(gl, shaders, [noisy], noisy, np.full(SHAPE, told))
    np.testing.assert_allclose(found, wanted, rtol=MEAN_TOLERANCE)


def test_light_without_noise_stays_as_it_is(gl, shaders):
    level, _, _ = slats(np.random.default_rng(3), 0.0)
    ramp = level + np.linspace(0.0, 1.0, SHAPE[1])
    (found,) = run(gl, shaders, [ramp], ramp, np.zeros(SHAPE))
    np.testing.assert_allclose(found, ramp, rtol=MEAN_TOLERANCE)


def test_what_is_no_number_spreads_nowhere(gl, shaders):
    _, noisy, variance = slats(np.random.default_rng(4), 0.05)
    (usual,) = run(gl, shaders, [noisy], noisy, variance)
    noisy[20, 20] = variance[20, 20] = np.nan
    (found,) = run(gl, shaders, [noisy], noisy, variance)
    assert np.isfinite(found).all()
    near = np.zeros(SHAPE, bool)
    near[20 - 2 * RADIUS : 21 + 2 * RADIUS, 20 - 2 * RADIUS : 21 + 2 * RADIUS] = True
    np.testing.assert_allclose(found[~near], usual[~near], rtol=MEAN_TOLERANCE)


@pytest.mark.parametrize("name", ["naive", "none"])
def test_other_filters_know_no_levels(name):
    item = EdgeAwareFilterPass(
        "filter",
        EdgeAwareFilterSettings(filter=name),
        Signal("raw", "smooth"),
        levels=Levels("light", TOLERANCE),
    )
    assert "light" not in item.reads
