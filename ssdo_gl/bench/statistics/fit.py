"""Fits power laws to measured series: how cost and error grow."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

# Fewer points leave a slope without a standard error.
MIN_POINTS = 3


@dataclass(frozen=True)
class PowerLaw:
    """y = factor * x ** exponent, with the exponent's standard error."""

    factor: float
    exponent: float
    standard_error: float

    def __str__(self) -> str:
        return f"{self.exponent:+.2f} ± {self.standard_error:.2f}"


def fit_power_law(x: Sequence[float], y: Sequence[float]) -> PowerLaw | None:
    """Return the least-squares line in log-log; None for fewer than three usable points.

    Points that are not positive and finite have no logarithm and are left out.
    """
    points = np.array([x, y], dtype=np.float64)
    u, v = np.log(points[:, np.all((points > 0.0) & np.isfinite(points), axis=0)])
    if len(u) < MIN_POINTS or np.ptp(u) == 0.0:
        return None
    (slope, intercept), covariance = np.polyfit(u, v, 1, cov=True)
    return PowerLaw(math.exp(intercept), float(slope), math.sqrt(covariance[0, 0]))
