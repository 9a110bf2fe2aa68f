"""Closed forms of near-field visibility, float64. Imports nothing from ssdo_gl.

A point on a floor looks at a wall at distance d; rays have length R; k = d / R. The
cosine-weighted measure of a set of directions is the area of their projection onto the
unit disk, divided by pi (Nusselt), so a wall that every ray with w_x >= k meets covers
the segment of the disk beyond the chord at k. Each form was checked against Monte Carlo.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def disk_segment_area(k: Array | float) -> Array:
    """Return the area of the unit disk beyond a chord at distance k in [0, 1]."""
    k = np.clip(np.asarray(k, np.float64), 0.0, 1.0)
    return np.asarray(np.arccos(k) - k * np.sqrt(1.0 - k * k))


def corner_occlusion(k: Array | float) -> Array:
    """A1: cosine-weighted occlusion by a wall at distance k R; 0 beyond R."""
    return disk_segment_area(k) / np.pi


def corner_occlusion_uniform(k: Array | float) -> Array:
    """A2: the same without the cosine: half a spherical cap."""
    return (1.0 - np.clip(np.asarray(k, np.float64), 0.0, 1.0)) / 2.0


def corner_occlusion_of_points(
    k: float, survival: Callable[[Array], Array], nodes: int = 20001
) -> float:
    """A3, A4: expected occlusion when each direction is tried at random distances.

    A direction with x component x is found blocked if a point lies at k R / x or
    farther; `survival(q)` is the probability that some point lies at q R or farther
    (1 - q for one point uniform in [0, R]).
    """
    # x = k + (1 - k) t^2 spreads the nodes where the integrand changes fastest.
    t = np.linspace(0.0, 1.0, nodes)
    x = k + (1.0 - k) * t * t
    f = np.sqrt(np.maximum(1.0 - x * x, 0.0)) * survival(np.minimum(k / x, 1.0))
    return float(2.0 / np.pi * np.sum((f[1:] + f[:-1]) / 2.0 * np.diff(x)))


def corner_occlusion_rgs09(k: Array | float) -> Array:
    """A3 in closed form: one point per direction, uniform in [0, R]."""
    k = np.asarray(k, np.float64)
    s = np.sqrt(1.0 - k * k)
    return np.asarray((np.arccos(k) + k * s - 2.0 * k * np.log((1.0 + s) / k)) / np.pi)


def box_corner_occlusion(k1: float, k2: float) -> float:
    """B: cosine-weighted occlusion by two perpendicular walls at k1 R and k2 R."""
    overlap = 0.0
    if k1 * k1 + k2 * k2 < 1.0:
        t = np.sqrt(1.0 - k2 * k2)

        def area(x: float) -> float:
            return float((x * np.sqrt(1.0 - x * x) + np.arcsin(x)) / 2.0)

        overlap = area(t) - area(k1) - k2 * (t - k1)
    return float((disk_segment_area(k1) + disk_segment_area(k2) - overlap) / np.pi)


def sphere_on_plane_occlusion(rho: Array | float, radius: float) -> Array:
    """E1: occlusion at ground distance rho from where a sphere rests on the plane.

    Exact for rays of length rho or more: no tangent to the sphere is longer.
    """
    return np.asarray((1.0 + (np.asarray(rho, np.float64) / radius) ** 2) ** -1.5)


def rectangle_form_factor(corners: Array, normal: Array) -> float:
    """F: fraction of the cosine-weighted hemisphere that a polygon covers (Lambert).

    `corners` (n, 3) are relative to the point and wholly above its horizon; the sign
    is positive where they run clockwise seen from the point.
    """
    unit = corners / np.linalg.norm(corners, axis=1, keepdims=True)
    total = 0.0
    for a, b in zip(unit, np.roll(unit, -1, axis=0), strict=True):
        cross = np.cross(a, b)
        length = float(np.linalg.norm(cross))
        total += float(np.arctan2(length, a @ b)) * float(cross @ normal) / length
    return total / (2.0 * np.pi)
