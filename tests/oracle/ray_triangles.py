"""Rays against all triangles, one by one, in float64. Imports nothing from ssdo_gl."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def intersect_all(
    origins: Array, directions: Array, triangles: Array
) -> tuple[Array, NDArray[np.int64]]:
    """Return distance (inf: none) and triangle (-1: none) of each ray's nearest hit.

    Moeller, Trumbore 1997, both sides; origins, directions (N, 3), triangles (T, 3, 3).
    """
    a = triangles[:, 0]
    edge_1, edge_2 = triangles[:, 1] - a, triangles[:, 2] - a
    nearest = np.full(len(origins), np.inf)
    which = np.full(len(origins), -1)
    for i in range(len(triangles)):
        p = np.cross(directions, edge_2[i])
        determinant = p @ edge_1[i]
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = 1.0 / determinant
            s = origins - a[i]
            u = np.einsum("nk,nk->n", s, p) * inverse
            q = np.cross(s, edge_1[i])
            v = np.einsum("nk,nk->n", directions, q) * inverse
            t = (q @ edge_2[i]) * inverse
            hit = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t > 0.0) & (t < nearest)
        nearest = np.where(hit, t, nearest)
        which = np.where(hit, i, which)
    return nearest, which


def edge_clearance(points: Array, triangles: Array) -> Array:
    """Return the distance of points (N, 3) from the nearest edge line of triangles (N, 3, 3)."""
    result = np.full(len(points), np.inf)
    for i in range(3):
        a, b = triangles[:, i], triangles[:, (i + 1) % 3]
        along = (b - a) / np.linalg.norm(b - a, axis=1, keepdims=True)
        offset = points - a
        across = offset - np.einsum("nk,nk->n", offset, along)[:, None] * along
        result = np.minimum(result, np.linalg.norm(across, axis=1))
    return result
