"""Joins triangles that share an edge into pairs, the primitives of the hierarchy.

Four vertices fill three RGBA texels exactly, so testing a pair costs the same three
fetches as testing one triangle, and a quadrilateral, the most frequent shape of built
scenes, is one primitive.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, IntArray
from ssdo_gl.raytracing.split import half_area
from ssdo_gl.scene.geometry import spans

# Each round pairs the triangles that prefer each other; after four, fewer than one in
# ten of a scanned mesh's triangles is left single.
ROUND_COUNT = 4
# A pair may cover at most this much more box surface than its triangles apart: two
# coplanar halves of a quadrilateral have 0.5 to 1, two leaves of an open book more.
MAX_AREA_RATIO = 1.0


@dataclass(frozen=True, eq=False)
class Pairs:
    """Primitives of one or two triangles.

    Attributes
    ----------
    triangles : ndarray, shape (P, 2), int64
        Source triangles (v0, v1, v2) and (v0, v2, v3); -1 where there is no second.
    corners : ndarray, shape (P, 2, 3), int64
        Which corner of its source triangle each of those vertices is.
    """

    triangles: IntArray
    corners: IntArray


def vertex_ids(positions: NDArray[np.float32]) -> IntArray:
    """Number equal positions (N, 3) alike. Different ones may never share a number."""
    # Multiplicative hash; odd constants of high entropy (golden ratio, Murmur3, xxHash).
    factors = (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9)
    columns = [(positions[:, axis] + np.float32(0.0)).view(np.uint32) for axis in range(3)]
    key = np.zeros(len(positions), dtype=np.uint64)
    for bits, factor in zip(columns, factors, strict=True):
        key ^= bits.astype(np.uint64) * np.uint64(factor)
    order = np.argsort(key)
    changed = np.zeros(len(positions), dtype=bool)
    for bits in columns:
        arranged = bits[order]
        changed[1:] |= arranged[1:] != arranged[:-1]
    ids = np.empty(len(positions), dtype=np.int64)
    ids[order] = np.cumsum(changed)
    return ids


def stable_order(keys: NDArray[Any]) -> IntArray:
    """Return what a stable argsort does, of fewer than 2^32 keys, in half its time."""
    order = np.argsort(keys)
    arranged = keys[order]
    run = np.zeros(len(keys), dtype=np.uint64)
    np.cumsum(arranged[1:] != arranged[:-1], out=run[1:])
    # Equal keys by their place.
    place = run << np.uint64(32) | order.astype(np.uint64)
    place.sort()
    return (place & np.uint64(0xFFFFFFFF)).astype(np.int64)


def pair_triangles(positions: NDArray[np.float32], vertices: IntArray | None = None) -> Pairs:
    """Pair triangles (T, 3, 3) that share an edge with opposite direction.

    Opposite direction means the same orientation of both surfaces, which a pair must
    keep, because the winding says which side of a triangle is its front.

    Parameters
    ----------
    vertices : ndarray, shape (T, 3), or None
        `SceneTriangles.vertices`; None: found from the positions.
    """
    count = len(positions)
    if vertices is None:
        vertices = vertex_ids(positions.reshape(-1, 3)).reshape(-1, 3)
    mine, other, mine_edge, other_edge = _shared_edges(vertices)
    ratio = _area_ratios(positions, mine, other)
    keep = np.flatnonzero(ratio <= MAX_AREA_RATIO)
    keep = keep[stable_order(ratio[keep])]
    mine, other, mine_edge, other_edge = (
        array[keep] for array in (mine, other, mine_edge, other_edge)
    )

    single = np.ones(count, dtype=bool)
    found = []
    for _ in range(ROUND_COUNT):
        alive = np.flatnonzero(single[mine] & single[other])
        if len(alive) == 0:
            break
        # Edges come best first, so the last write in reverse order is a triangle's best.
        best = np.full(count, -1, dtype=np.int64)
        best[other[alive][::-1]] = alive[::-1]
        best_of_mine = np.full(count, -1, dtype=np.int64)
        best_of_mine[mine[alive][::-1]] = alive[::-1]
        preferred = _smaller(best, best_of_mine)
        chosen = alive[(preferred[mine[alive]] == alive) & (preferred[other[alive]] == alive)]
        single[mine[chosen]] = single[other[chosen]] = False
        found.append(chosen)
    chosen = np.concatenate(found) if found else np.empty(0, dtype=np.int64)
    return _assemble(mine[chosen], other[chosen], mine_edge[chosen], other_edge[chosen], single)


def _area_ratios(positions: NDArray[np.float32], mine: IntArray, other: IntArray) -> FloatArray:
    """Return the surface of the boxes of pairs over that of their triangles' boxes, (N,)."""
    low, high = positions.min(axis=1), positions.max(axis=1)
    area = half_area(low, high)
    ratio = np.empty(len(mine))
    for span in spans(len(mine)):
        one, two = mine[span], other[span]
        joint = half_area(np.minimum(low[one], low[two]), np.maximum(high[one], high[two]))
        ratio[span] = joint / np.maximum(area[one] + area[two], np.finfo(np.float64).tiny)
    return ratio


def _smaller(a: IntArray, b: IntArray) -> IntArray:
    """Return the smaller of two ranks, where -1 means none."""
    return np.asarray(np.where(a < 0, b, np.where(b < 0, a, np.minimum(a, b))))


def _shared_edges(corner: IntArray) -> tuple[IntArray, IntArray, IntArray, IntArray]:
    """Return (triangle, other triangle, edge, other's edge), each edge of corners (T, 3) once.

    Edge i runs from corner i to corner i + 1. Where more than two triangles meet in an
    edge, consecutive ones in index order are offered.
    """
    start, end = corner.reshape(-1), np.roll(corner, -1, axis=1).reshape(-1)
    size = np.int64(corner.max() + 1)
    key = np.minimum(start, end) * size + np.maximum(start, end)
    order = stable_order(key)
    key = key[order]
    near = np.flatnonzero(key[:-1] == key[1:])
    a, b = order[near], order[near + 1]
    shared = (start[a] == end[b]) & (a // 3 != b // 3)
    a, b = a[shared], b[shared]
    return a // 3, b // 3, a % 3, b % 3


def _assemble(
    mine: IntArray,
    other: IntArray,
    mine_edge: IntArray,
    other_edge: IntArray,
    single: NDArray[np.bool_],
) -> Pairs:
    # The shared edge of the first triangle runs v2 -> v0, of the second v0 -> v2.
    first = (mine_edge[:, None] + np.array([1, 2, 0])) % 3
    second = (other_edge[:, None] + np.array([0, 1, 2])) % 3
    alone = np.flatnonzero(single)
    triangles = np.concatenate(
        [np.stack([mine, other], axis=1), np.stack([alone, np.full_like(alone, -1)], axis=1)]
    )
    identity = np.broadcast_to(np.array([0, 1, 2]), (len(alone), 2, 3))
    corners = np.concatenate([np.stack([first, second], axis=1), identity])
    return Pairs(triangles, corners)


def pair_vertices(positions: NDArray[np.float32], pairs: Pairs) -> NDArray[np.float32]:
    """Return v0 to v3 (P, 4, 3) of pairs among triangles (T, 3, 3); v2 again where one is alone."""
    first = positions[pairs.triangles[:, :1], pairs.corners[:, 0]]
    second = positions[pairs.triangles[:, 1], pairs.corners[:, 1, 2]]
    alone = pairs.triangles[:, 1] < 0
    fourth = np.where(alone[:, None], first[:, 2], second)
    return np.concatenate([first, fourth[:, None]], axis=1)
