"""Confidence intervals for image errors: resamples pixel blocks and seeds.

Errors of neighbouring pixels go together (a filter, one occluder), so single pixels
must not be resampled as if they were independent. The frame is cut into square blocks;
blocks and seeds are drawn with replacement, the same draws for every setting of a
sweep, so that two settings are compared on the same pixels (paired bootstrap).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.images.error import FloatImage, Mask, failures, signed_error, squared_error

# Fewer blocks make percentile intervals too narrow, larger blocks keep more of the
# correlation inside: the frame is cut into at least this many.
MIN_BLOCK_COUNT = 60
# Beyond this side the correlation of filter and near field is inside one block at the
# radii that a frame of ordinary size uses.
MAX_BLOCK_PX = 32
REPLICA_COUNT = 1000
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Interval:
    """An estimate with its confidence interval."""

    value: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.value:.4g} [{self.low:.4g}, {self.high:.4g}]"


def block_size(size: tuple[int, int]) -> int:
    """Return the side of a block in pixels for a frame of (width, height)."""
    width, height = size
    return max(1, min(MAX_BLOCK_PX, math.isqrt(max(1, width * height // MIN_BLOCK_COUNT))))


def block_labels(size: tuple[int, int], side_px: int) -> NDArray[np.int64]:
    """Return the number of the block that each pixel belongs to, shape (height, width)."""
    width, height = size
    across = -(-width // side_px)
    rows, columns = np.arange(height) // side_px, np.arange(width) // side_px
    return np.asarray(rows[:, None] * across + columns[None, :], dtype=np.int64)


def block_sums(
    values: NDArray[np.float64], mask: Mask, labels: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Return the sum of `values` where `mask`, for every block."""
    count = int(labels.max()) + 1
    sums = np.bincount(labels[mask], weights=values[mask], minlength=count)
    return np.asarray(sums, dtype=np.float64)


@dataclass(frozen=True, eq=False)
class BlockErrors:
    """The error of one setting against one reference, summed over pixel blocks.

    Attributes
    ----------
    squared, signed : ndarray, shape (seeds, blocks)
        Sums of the squared (reference's noise subtracted) and of the signed error.
    reference : ndarray, shape (blocks,)
        Sums of the reference's value.
    pixels : ndarray, shape (blocks,)
        How many pixels count.
    failures : int
        Pixels with NaN or infinity, all seeds together.
    """

    squared: NDArray[np.float64]
    signed: NDArray[np.float64]
    reference: NDArray[np.float64]
    pixels: NDArray[np.float64]
    failures: int = 0

    @staticmethod
    def of_images(
        images: list[FloatImage],
        reference: FloatImage,
        mask: Mask,
        reference_variance: FloatImage | None = None,
        side_px: int | None = None,
    ) -> BlockErrors:
        """Sum the errors of `images` (one per seed) over blocks."""
        height, width = mask.shape
        labels = block_labels((width, height), side_px or block_size((width, height)))
        squared = [
            block_sums(squared_error(image, reference, reference_variance), mask, labels)
            for image in images
        ]
        signed = [block_sums(signed_error(image, reference), mask, labels) for image in images]
        level = reference.astype(np.float64).mean(axis=2)
        failure_count = sum(int(np.count_nonzero(mask & failures(image))) for image in images)
        return BlockErrors(
            np.stack(squared),
            np.stack(signed),
            block_sums(level, mask, labels),
            block_sums(np.ones_like(level), mask, labels),
            failure_count,
        )

    @property
    def seed_count(self) -> int:
        """How many seeds were rendered."""
        return len(self.squared)

    @property
    def block_count(self) -> int:
        """How many blocks the frame is cut into."""
        return len(self.pixels)


@dataclass(frozen=True, eq=False)
class Draws:
    """Which blocks and seeds each bootstrap replica holds, as weights.

    Attributes
    ----------
    blocks : ndarray, shape (replicas, blocks)
        How often each block was drawn.
    seeds : ndarray, shape (replicas, seeds)
        Weight of each seed; sums to 1.
    """

    blocks: NDArray[np.float64]
    seeds: NDArray[np.float64]


def draw(
    block_count: int,
    seed_count: int,
    replicas: int = REPLICA_COUNT,
    rng: np.random.Generator | None = None,
) -> Draws:
    """Draw the replicas that all settings of one sweep share."""
    rng = rng or np.random.default_rng(0)
    even = np.full(block_count, 1.0 / block_count)
    blocks = rng.multinomial(block_count, even, size=replicas).astype(np.float64)
    shares = np.full(seed_count, 1.0 / seed_count)
    seeds = rng.multinomial(seed_count, shares, size=replicas) / seed_count
    return Draws(blocks, seeds.astype(np.float64))


def _mean(sums: NDArray[np.float64], errors: BlockErrors, draws: Draws) -> NDArray[np.float64]:
    """Return the mean over pixels and seeds of `sums` (seeds, blocks) in every replica."""
    with np.errstate(invalid="ignore"):
        per_block = np.einsum("rs,sb->rb", draws.seeds, sums)
        total = np.einsum("rb,rb->r", draws.blocks, per_block)
    # A weight of zero times an infinite error is NaN: a failure stays a failure.
    total = np.where(np.isnan(total), np.inf, total)
    return np.asarray(total / np.maximum(draws.blocks @ errors.pixels, 1.0))


def rmse_replicas(errors: BlockErrors, draws: Draws, *, relative: bool) -> NDArray[np.float64]:
    """Return the RMSE of every replica; 0 where the mean square came out negative.

    `relative`: over the replica's mean reference; infinite where that is black.
    """
    error = np.sqrt(np.maximum(_mean(errors.squared, errors, draws), 0.0))
    if not relative:
        return error
    level = (draws.blocks @ errors.reference) / np.maximum(draws.blocks @ errors.pixels, 1.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = error / level
    return np.where(level > 0.0, ratio, np.where(error == 0.0, 0.0, np.inf))


def bias_replicas(errors: BlockErrors, draws: Draws) -> NDArray[np.float64]:
    """Return the mean signed error of every replica."""
    return _mean(errors.signed, errors, draws)


def whole(errors: BlockErrors) -> Draws:
    """Return the one "replica" that is the measured sample itself."""
    return Draws(
        np.ones((1, errors.block_count)),
        np.full((1, errors.seed_count), 1.0 / errors.seed_count),
    )


def percentile_interval(
    value: float, replicas: NDArray[np.float64], confidence: float = CONFIDENCE
) -> Interval:
    """Return the percentile bootstrap interval around `value`."""
    if not np.isfinite(replicas).all():
        finite = replicas[np.isfinite(replicas)]
        low = float(np.min(finite)) if finite.size and math.isfinite(value) else value
        return Interval(value, low, math.inf)
    tail = 50.0 * (1.0 - confidence)
    low, high = np.percentile(replicas, [tail, 100.0 - tail])
    return Interval(value, float(low), float(high))


def rmse_of(errors: BlockErrors, *, relative: bool) -> float:
    """Return the (relative) RMSE of the sample itself."""
    return float(rmse_replicas(errors, whole(errors), relative=relative)[0])


def rmse_interval(errors: BlockErrors, draws: Draws, *, relative: bool) -> Interval:
    """Return the (relative) RMSE of the sample with its confidence interval."""
    replicas = rmse_replicas(errors, draws, relative=relative)
    return percentile_interval(rmse_of(errors, relative=relative), replicas)


def bias_interval(errors: BlockErrors, draws: Draws) -> Interval:
    """Return the mean signed error with its confidence interval."""
    value = float(bias_replicas(errors, whole(errors))[0])
    return percentile_interval(value, bias_replicas(errors, draws))


def median_replicas(
    times: NDArray[np.float64], replicas: int, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return bootstrap replicas of the median of each row of `times`.

    Parameters
    ----------
    times : ndarray, shape (points, rounds)
        Rounds are drawn alike for all points, since they were measured together.

    Returns
    -------
    ndarray, shape (replicas, points)
    """
    count = times.shape[1]
    drawn = rng.integers(0, count, size=(replicas, count))
    return np.stack([np.median(times[:, columns], axis=1) for columns in drawn])
