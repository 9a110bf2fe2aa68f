"""Accepting Monte-Carlo results: tests of means, corrected for how many are made.

Imports nothing from ssdo_gl.
"""

from __future__ import annotations

from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def sidak_level(significance: float, count: int) -> float:
    """Return the level of each of `count` tests that gives `significance` for all."""
    return 1.0 - (1.0 - significance) ** (1.0 / count)


def student_quantile(level: float, degrees: int) -> float:
    """Return the two-sided quantile of Student's t: |t| exceeds it with chance `level`.

    Cornish-Fisher expansion in 1 / degrees; at 31 degrees and level 1e-6 0.4 % too small.
    """
    z = NormalDist().inv_cdf(1.0 - level / 2.0)
    g1 = (z**3 + z) / 4.0
    g2 = (5.0 * z**5 + 16.0 * z**3 + 3.0 * z) / 96.0
    g3 = (3.0 * z**7 + 19.0 * z**5 + 17.0 * z**3 - 15.0 * z) / 384.0
    return z + g1 / degrees + g2 / degrees**2 + g3 / degrees**3


def chi_square_quantile(level: float, degrees: int) -> float:
    """Return the upper quantile of chi-square: it is exceeded with chance `level`.

    Wilson and Hilferty's cube; from 100 degrees on and down to a level of 1e-4 within
    0.1 %.
    """
    spread = 2.0 / (9.0 * degrees)
    z = NormalDist().inv_cdf(1.0 - level)
    return float(degrees * (1.0 - spread + z * spread**0.5) ** 3)


def worst_deviation(
    runs: Array,
    expected: Array | float,
    allowance: Array | float = 0.0,
    significance: float = 0.01,
    rays: int = 0,
) -> float:
    """Return the largest deviation of means from the expected, relative to what chance allows.

    Parameters
    ----------
    runs : ndarray, shape (K, ...)
        Independent estimates of the same quantities, K >= 16.
    expected : array_like
        Broadcast against ``runs[0]``.
    allowance : array_like
        Systematic error that is known and accepted, in the unit of the quantity.
    rays : int
        If the quantities are shares of so many rays in all runs together: events rarer
        than a few in so many may not have been seen, without any spread to tell.
    significance : float
        Chance that correct estimates exceed 1 anywhere.

    Returns
    -------
    float
        At most 1 if the estimates agree with the expected.
    """
    count = len(runs)
    mean = runs.mean(axis=0)
    # A quantity without any spread is exact or wrong; rounding is all that it may differ.
    spread = runs.std(axis=0, ddof=1) / np.sqrt(count)
    limit = student_quantile(sidak_level(significance, mean.size), count - 1)
    rounding = 1e-6 * np.abs(mean) + 1e-12
    if rays:
        rounding = rounding - np.log(sidak_level(significance, mean.size)) / rays
    allowed = limit * spread + np.broadcast_to(allowance, mean.shape) + rounding
    return float(np.max(np.abs(mean - expected) / allowed))


def two_sample_deviation(
    first: Array, second: Array, allowance: Array | float = 0.0, significance: float = 0.01
) -> float:
    """The same for two sets of runs (K, ...) and (M, ...) of the same quantities."""
    variance = first.var(axis=0, ddof=1) / len(first) + second.var(axis=0, ddof=1) / len(second)
    difference = first.mean(axis=0) - second.mean(axis=0)
    degrees = min(len(first), len(second)) - 1
    limit = student_quantile(sidak_level(significance, difference.size), degrees)
    scale = np.abs(second.mean(axis=0))
    allowed = limit * np.sqrt(variance) + allowance + 1e-6 * scale + 1e-12
    return float(np.max(np.abs(difference) / allowed))
