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
    pairs = [
        (math.log(a), math.log(b))
        for a, b in zip(x, y, strict=True)
        if a > 0.0 and b > 0.0 and math.isfinite(a) and math.isfinite(b)
    ]
    if len(pairs) < MIN_POINTS:
        return None
    u, v = np.array(pairs).T
    spread = float(((u - u.mean()) ** 2).sum())
    if spread == 0.0:
        return None
    slope = float(((u - u.mean()) * (v - v.mean())).sum() / spread)
    intercept = float(v.mean() - slope * u.mean())
    residual = float(((v - intercept - slope * u) ** 2).sum())
    error = math.sqrt(residual / (len(pairs) - 2) / spread)
    return PowerLaw(math.exp(intercept), slope, error)
