"""Shadows by segments, float64. Imports nothing from ssdo_gl."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def card_blocks(
    start: Array, end: Array, corner: ArrayLike, edge_u: ArrayLike, edge_v: ArrayLike
) -> NDArray[np.bool_]:
    """Return whether a parallelogram lies between points `start` and `end` (..., 3)."""
    corner, u, v = (np.asarray(a, np.float64) for a in (corner, edge_u, edge_v))
    n = np.cross(u, v)
    direction = end - start
    with np.errstate(divide="ignore", invalid="ignore"):
        t = ((corner - start) @ n) / (direction @ n)
        hit = start + t[..., None] * direction - corner
        a, b = hit @ np.cross(v, n) / (u @ np.cross(v, n)), hit @ np.cross(u, n)
        b = b / (v @ np.cross(u, n))
        inside = (a >= 0.0) & (a <= 1.0) & (b >= 0.0) & (b <= 1.0)
        return np.asarray(inside & (t > 0.0) & (t < 1.0))


def rectangle_visibility(
    points: Array,
    normal: Array,
    light: tuple[ArrayLike, ArrayLike, ArrayLike],
    cards: list[tuple[ArrayLike, ArrayLike, ArrayLike]],
    count: int = 32,
) -> Array:
    """Return the part of a rectangle light's irradiance that reaches `points` (N, 3).

    The integral of cos cos / distance^2 over count x count points of the light with the
    blocked ones left out, divided by that over all.
    """
    corner, u, v = (np.asarray(a, np.float64) for a in light)
    place = (np.arange(count) + 0.5) / count
    total, open_ = np.zeros(len(points)), np.zeros(len(points))
    for a in place:
        for b in place:
            y = corner + a * u + b * v
            d = y - points
            weight = np.maximum(d @ normal, 0.0) * np.maximum(-d @ np.cross(u, v), 0.0)
            weight /= (d * d).sum(1) ** 2
            blocked = np.zeros(len(points), bool)
            for card in cards:
                blocked |= card_blocks(points, np.broadcast_to(y, points.shape), *card)
            total += weight
            open_ += np.where(blocked, 0.0, weight)
    return open_ / total


def box_distance(origin: ArrayLike, directions: Array, low: ArrayLike, high: ArrayLike) -> Array:
    """Return how far rays from inside a box travel to its walls, in units of `directions`."""
    origin = np.asarray(origin, np.float64)
    with np.errstate(divide="ignore"):
        t = np.maximum((low - origin) / directions, (high - origin) / directions)
    return np.asarray(t.min(axis=-1))
