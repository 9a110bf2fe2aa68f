"""Polygons with any number of corners, convex or not, into triangles."""

from __future__ import annotations

import mapbox_earcut
import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.geometry import check_vertices

# Corners squared, summed over the polygons whose ears are clipped: 1 s for a star that
# crosses itself everywhere, .04 s for an outline that does not.
EAR_CLIPPING_LIMIT = 5e7
# Of a unit: what rounding may turn a collinear corner by.
_FLAT = 1e-9


def triangulated(
    positions: FloatArray, corners: NDArray[np.int64], counts: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return triangles of polygons that are given one after the other.

    Where the first corner sees the whole polygon, as in any convex one, its triangles
    are a fan around that corner. Ears are clipped from others, in the plane that
    fits them best. Polygons of fewer than three corners give nothing.

    Parameters
    ----------
    positions : ndarray, shape (V, 3)
    corners : ndarray, shape (sum of counts,)
        The vertex of each corner.
    counts : ndarray, shape (F,)
        Corners of each polygon.

    Returns
    -------
    triangles : ndarray, shape (T, 3)
        Indices into `corners`, wound like the polygons and in their order.
    polygons : ndarray, shape (T,)
        The polygon of each triangle.

    Raises
    ------
    ValueError
        If a corner names a vertex that does not exist.
    """
    check_vertices(corners, len(positions))
    if np.all(counts == 3):
        return np.arange(len(corners)).reshape(-1, 3), np.arange(len(counts))
    starts = np.cumsum(counts) - counts
    fans = np.maximum(counts - 2, 0)
    polygons = np.repeat(np.arange(len(counts)), fans)
    step = np.arange(len(polygons)) - np.repeat(np.cumsum(fans) - fans, fans)
    first = starts[polygons]
    triangles = np.stack([first, first + step + 1, first + step + 2], axis=1)
    concave = _seen_from_elsewhere(positions, corners, counts, starts)
    if not len(concave):
        return triangles, polygons
    kept = ~np.isin(polygons, concave)
    pieces, owners = [triangles[kept]], [polygons[kept]]
    work = 0.0
    for polygon in concave:
        span = np.arange(starts[polygon], starts[polygon] + counts[polygon])
        work += float(len(span)) ** 2
        clipped = _ears(positions[corners[span]]) if work <= EAR_CLIPPING_LIMIT else None
        piece = triangles[polygons == polygon] if clipped is None else span[clipped]
        pieces.append(piece)
        owners.append(np.full(len(piece), polygon))
    polygons = np.concatenate(owners)
    order = np.argsort(polygons, kind="stable")
    return np.concatenate(pieces)[order], polygons[order]


def _seen_from_elsewhere(
    positions: FloatArray,
    corners: NDArray[np.int64],
    counts: NDArray[np.int64],
    starts: NDArray[np.int64],
) -> NDArray[np.int64]:
    """Return the polygons of which a fan around the first corner leaves the inside."""
    found = []
    for count in np.unique(counts[counts > 3]):
        which = np.flatnonzero(counts == count)
        # A part at a time: polygons of very many corners are rare, and memory is not free.
        for part in np.array_split(which, max(1, len(which) * int(count) // 1_000_000)):
            local = _local(positions[corners[starts[part][:, None] + np.arange(count)]])
            fan = np.cross(local[:, 1:-1], local[:, 2:])
            normal = fan.sum(axis=1)
            length = np.linalg.norm(normal, axis=1, keepdims=True)
            normal = normal / np.where(length > 0.0, length, 1.0)
            # What has NaN corners or no area stays a fan, which is dropped or kept later.
            found.append(part[np.any((fan * normal[:, None]).sum(axis=2) < -_FLAT, axis=1)])
    return np.sort(np.concatenate(found)) if found else np.zeros(0, dtype=np.int64)


def _local(points: FloatArray) -> FloatArray:
    """Return points (..., N, 3) relative to the first, the largest coordinate being 1."""
    with np.errstate(invalid="ignore", over="ignore"):
        # Half before the difference: corners of either sign near the largest float.
        local = 0.5 * points - 0.5 * points[..., :1, :]
        size = np.abs(local).max(axis=(-2, -1), keepdims=True)
        return np.asarray(np.where(size > 0.0, local / np.where(size > 0.0, size, 1.0), 0.0))


def _ears(points: FloatArray) -> NDArray[np.int64] | None:
    """Return triangles (T, 3) of one polygon (N, 3), or None where it has no plane."""
    local = _local(points)
    normal = np.cross(local, np.roll(local, -1, axis=0)).sum(axis=0)
    length = np.linalg.norm(normal)
    if not length > _FLAT:
        return None
    normal = normal / length
    # Seen from its front, so that the triangles come out counter-clockwise as well.
    axis = np.eye(3)[np.argmin(np.abs(normal))]
    right = np.cross(axis, normal)
    right /= np.linalg.norm(right)
    flat = np.stack([local @ right, local @ np.cross(normal, right)], axis=1)
    ends = np.array([len(flat)], dtype=np.uint32)
    clipped = mapbox_earcut.triangulate_float64(flat, ends).reshape(-1, 3).astype(np.int64)
    return clipped if len(clipped) else None
