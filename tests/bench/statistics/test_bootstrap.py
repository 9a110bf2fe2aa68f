"""Bootstrap intervals: coverage on data whose variance is known, pairing, failures."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ssdo_gl.bench.statistics import bootstrap
from ssdo_gl.images import error


def blocks_of(
    rng: np.random.Generator, seeds: int, blocks: int, sigma: float, spread: float
) -> bootstrap.BlockErrors:
    """Return synthetic errors: every block has its own mean square, seeds add noise."""
    level = rng.gamma(4.0, sigma**2 / 4.0, size=blocks)
    squared = level[None, :] * (1.0 + spread * rng.standard_normal((seeds, blocks)))
    ones = np.ones(blocks)
    return bootstrap.BlockErrors(squared, np.zeros((seeds, blocks)), ones, ones)


def test_blocks_tile_the_frame():
    labels = bootstrap.block_labels((70, 40), 32)
    assert labels.shape == (40, 70)
    assert labels[0, 0] == 0
    assert labels[0, 69] == 2
    assert labels[39, 69] == 5
    np.testing.assert_array_equal(np.unique(labels), np.arange(6))


@pytest.mark.parametrize("size", [(320, 180), (640, 360), (1920, 1080), (64, 36), (7, 3)])
def test_a_frame_has_blocks_enough(size):
    side = bootstrap.block_size(size)
    assert 1 <= side <= bootstrap.MAX_BLOCK_PX
    if size[0] * size[1] >= bootstrap.MIN_BLOCK_COUNT:
        assert size[0] * size[1] / side**2 >= bootstrap.MIN_BLOCK_COUNT


def test_block_sums_give_back_the_image_metrics():
    rng = np.random.default_rng(0)
    reference = rng.random((40, 70, 3))
    images = [reference + rng.normal(0.05, 0.1, reference.shape) for _ in range(3)]
    mask = rng.random((40, 70)) < 0.7
    errors = bootstrap.BlockErrors.of_images(images, reference, mask)
    draws = bootstrap.draw(errors.block_count, 3)
    mean_square = np.mean([error.rmse(image, reference, mask) ** 2 for image in images])
    rmse = bootstrap.rmse_interval(errors, draws, relative=False)
    assert rmse.value == pytest.approx(math.sqrt(mean_square), rel=1e-12)
    relative = bootstrap.rmse_interval(errors, draws, relative=True)
    level = error.masked_mean(reference.mean(axis=2), mask)
    assert relative.value == pytest.approx(math.sqrt(mean_square) / level, rel=1e-12)
    bias = bootstrap.bias_interval(errors, draws)
    assert bias.value == pytest.approx(
        np.mean([error.bias(image, reference, mask) for image in images]), rel=1e-9
    )
    assert rmse.low < rmse.value < rmse.high
    assert bias.low < bias.value < bias.high


def test_intervals_cover_the_true_value_as_often_as_they_say():
    rng = np.random.default_rng(5)
    sigma, trials, hits = 0.1, 300, 0
    for _ in range(trials):
        errors = blocks_of(rng, seeds=4, blocks=80, sigma=sigma, spread=0.2)
        draws = bootstrap.draw(80, 4, replicas=300, rng=rng)
        interval = bootstrap.rmse_interval(errors, draws, relative=False)
        hits += interval.low <= sigma <= interval.high
    # 95 % nominal; percentile intervals of 80 skewed blocks come out a little narrow
    # (93 to 94 %), and 300 trials scatter by 1.4 %. An interval that forgot the blocks'
    # correlation or the square root would be far outside.
    assert 0.89 <= hits / trials <= 0.985


def test_the_width_is_the_known_standard_error():
    rng = np.random.default_rng(6)
    blocks, variance = 400, 0.25
    squared = 1.0 + math.sqrt(variance) * rng.standard_normal((1, blocks))
    errors = bootstrap.BlockErrors(squared, np.zeros((1, blocks)), np.ones(blocks), np.ones(blocks))
    replicas = bootstrap.rmse_replicas(errors, bootstrap.draw(blocks, 1, 2000), relative=False) ** 2
    # Standard deviation of a mean: sqrt(var / n); 2000 replicas know it to 2 %, the
    # sample's own variance to 4 %.
    assert replicas.std() == pytest.approx(math.sqrt(variance / blocks), rel=0.15)


def test_blocks_weigh_by_their_pixels():
    # The same error everywhere: however blocks of different size are drawn, it stays.
    pixels = np.array([1.0, 10.0, 100.0, 5.0])
    errors = bootstrap.BlockErrors(0.04 * pixels[None], 0.1 * pixels[None], 0.5 * pixels, pixels)
    draws = bootstrap.draw(4, 1, 200)
    np.testing.assert_allclose(bootstrap.rmse_replicas(errors, draws, relative=False), 0.2)
    np.testing.assert_allclose(bootstrap.rmse_replicas(errors, draws, relative=True), 0.4)
    np.testing.assert_allclose(bootstrap.bias_replicas(errors, draws), 0.1)


def test_intervals_are_percentiles():
    interval = bootstrap.percentile_interval(7.0, np.arange(1001.0), confidence=0.9)
    assert (interval.low, interval.high) == pytest.approx((50.0, 950.0))
    assert interval.value == 7.0


def test_seeds_widen_the_interval():
    blocks = 50
    same = np.ones((2, blocks))
    differing = np.stack([np.full(blocks, 0.5), np.full(blocks, 1.5)])
    draws = bootstrap.draw(blocks, 2)
    rest = (np.zeros((2, blocks)), np.ones(blocks), np.ones(blocks))
    narrow = bootstrap.rmse_replicas(bootstrap.BlockErrors(same, *rest), draws, relative=False) ** 2
    wide = (
        bootstrap.rmse_replicas(bootstrap.BlockErrors(differing, *rest), draws, relative=False) ** 2
    )
    assert narrow.std() == pytest.approx(0.0, abs=1e-12)
    # Two seeds of 0.5 and 1.5: the mean of two draws is 0.5, 1 or 1.5 with 1/4, 1/2, 1/4.
    assert wide.std() == pytest.approx(math.sqrt(0.125), rel=0.1)


def test_pairing_makes_differences_sharp():
    rng = np.random.default_rng(7)
    worse = blocks_of(rng, 1, 100, 1.0, 0.0)
    better = bootstrap.BlockErrors(0.9 * worse.squared, worse.signed, worse.reference, worse.pixels)
    draws = bootstrap.draw(100, 1)
    # 10 % better in every block: always better, although the intervals overlap widely.
    a, b = (bootstrap.rmse_replicas(e, draws, relative=False) ** 2 for e in (worse, better))
    assert (b < a).all()
    first, second = (bootstrap.rmse_interval(e, draws, relative=False) for e in (worse, better))
    assert second.high > first.low


def test_a_failure_makes_the_error_infinite():
    reference = np.ones((8, 8, 1))
    broken = reference.copy()
    broken[2, 3] = np.nan
    mask = np.ones((8, 8), dtype=bool)
    errors = bootstrap.BlockErrors.of_images([reference, broken], reference, mask, side_px=4)
    assert errors.failures == 1
    draws = bootstrap.draw(errors.block_count, 2)
    interval = bootstrap.rmse_interval(errors, draws, relative=False)
    assert interval.value == math.inf
    assert interval.high == math.inf
    assert not np.isnan(bootstrap.rmse_replicas(errors, draws, relative=False)).any()
    assert not np.isnan(bootstrap.bias_replicas(errors, draws)).any()


def test_a_failure_in_the_background_does_not_count():
    reference = np.ones((8, 8, 1))
    broken = reference.copy()
    broken[2, 3] = np.nan
    mask = np.ones((8, 8), dtype=bool)
    mask[2, 3] = False
    errors = bootstrap.BlockErrors.of_images([broken], reference, mask, side_px=4)
    assert errors.failures == 0
    assert np.isfinite(errors.squared).all()


def test_median_replicas_are_medians_of_drawn_rounds():
    times = np.array([[1.0, 1.0, 1.0], [1.0, 2.0, 9.0]])
    replicas = bootstrap.median_replicas(times, 500, np.random.default_rng(8))
    assert replicas.shape == (500, 2)
    assert (replicas[:, 0] == 1.0).all()
    assert set(np.unique(replicas[:, 1])) == {1.0, 2.0, 9.0}
    # The median of three draws is the middle value with probability 13/27.
    assert np.mean(replicas[:, 1] == 2.0) == pytest.approx(13 / 27, abs=0.08)
