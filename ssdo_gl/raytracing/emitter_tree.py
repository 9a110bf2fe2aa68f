"""A binary tree over emitting surfaces, in which rays find those that matter to a point.

A node bounds where its emitters are, which way they face and how much they send, from which a
walk downwards chooses by chance (Conty Estevez, Kulla 2018).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray
from ssdo_gl.raytracing.emitter_tables import KIND_TRIANGLE, TWO_SIDED_CODE

NODE_TEXELS = 3
# A walk takes as many steps at most; of more emitters than 2^MOST_LEVELS some share a leaf.
MOST_LEVELS = 15
# A gap of this share of a node's extent parts what lies on both sides, as lamps.
_GAP = 0.1
# Of lengths, as in the normalised frame.
_ROUNDING = 1e-7


@dataclass(frozen=True, eq=False)
class EmitterTree:
    """A complete tree: the children of node i are 2 i + 1 and 2 i + 2.

    Attributes
    ----------
    order : ndarray, shape (N,), int64
        The emitters, leaf by leaf.
    ends : ndarray, shape (L,), int64
        How many emitters there are up to and with each leaf.
    nodes : ndarray, shape (2 L - 1, 3, 4), float32
        Texels: 0 = centre of a box around the emitters, their area; 1 = unit axis of a cone around
        their normals, and the cosine of its half-angle; 2 = half of the box's extent, their power,
        0: nothing.
    levels : int
        Steps from the root to a leaf: L = 2^levels.
    """

    order: NDArray[np.int64]
    ends: NDArray[np.int64]
    nodes: NDArray[np.float32]
    levels: int

    @property
    def leaves(self) -> NDArray[np.int64]:
        """The leaf of each emitter, (N,)."""
        count = len(self.order)
        result = np.empty(count, dtype=np.int64)
        result[self.order] = np.searchsorted(self.ends, np.arange(count), side="right")
        return result


def emitter_tree(entries: NDArray[np.float32]) -> EmitterTree:
    """Return a tree over surfaces, `entries` (N, 8, 4) of `EmitterTables`."""
    count = len(entries)
    levels = min(max(count - 1, 0).bit_length(), MOST_LEVELS)
    rows = entries.astype(np.float64)
    code = rows[:, 0, 3].astype(np.int64)
    is_triangle = code % TWO_SIDED_CODE == KIND_TRIANGLE
    two_sided = code & TWO_SIDED_CODE > 0
    power = rows[:, 2, 3] * rows[:, 3, :3].mean(axis=1) * rows[:, 5, 3] * (1.0 + two_sided)
    corner, edge_u, edge_v = (rows[:, texel, :3] for texel in range(3))
    points = np.stack([corner, corner + edge_u, corner + edge_v, corner + edge_u + edge_v], axis=1)
    points[is_triangle, 3] = corner[is_triangle]
    area = rows[:, 2, 3]
    normal = np.cross(edge_u, edge_v)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    low, high = points.min(axis=1), points.max(axis=1)
    middle = 0.5 * (low + high)
    order, starts = np.arange(count), np.array([0, count])
    nodes = np.zeros((2 ** (levels + 1) - 1, NODE_TEXELS, 4), dtype=np.float32)
    for level in range(levels + 1):
        filled = np.flatnonzero(np.diff(starts))
        first = starts[filled]
        node = np.repeat(np.arange(len(filled)), np.diff(starts)[filled])
        bounds = _Runs(first, node, order)
        nodes[2**level - 1 + filled] = _nodes(bounds, low, high, area, normal, two_sided, power)
        if level < levels:
            place = bounds.widest(middle)
            along = np.lexsort((place, node))
            order = order[along]
            # As many as the leaves of one half hold, if all others do.
            most = -(-count >> levels) << levels - level - 1
            halves = np.zeros(2**level, dtype=np.int64)
            halves[filled] = _halves(place[along], first, node, most)
            starts = np.append(np.stack([starts[:-1], starts[:-1] + halves], axis=1), count)
    return EmitterTree(order, starts[1:], nodes, levels)


def _halves(
    place: FloatArray, first: NDArray[np.int64], node: NDArray[np.int64], most: int
) -> NDArray[np.int64]:
    """Return how many of each run's emitters, which lie at `place` in order, its first half has.

    The gap next to the middle parts them, as between two lamps: a node of parts of both is as large
    as their distance, and next to one of these seldom chosen, but sends much. Else half of them,
    whatever they face: by that first, nodes would be as large as all lamps.
    """
    count = np.diff(np.append(first, len(place)))
    if not len(place):
        return count
    before = np.arange(len(place)) - first[node]
    extent = place[first + count - 1] - place[first]
    parts = np.diff(place, prepend=place[:1]) > _GAP * extent[node]
    smaller = np.minimum(before, count[node] - before)
    parts &= smaller >= np.maximum(count - most, 1)[node]
    best = np.maximum.reduceat(np.where(parts, smaller, 0), first)
    where = np.minimum.reduceat(
        np.where(parts & (smaller == best[node]), before, len(place)), first
    )
    return np.where(best > 0, where, (count + 1) // 2)


@dataclass(frozen=True, eq=False)
class _Runs:
    """Consecutive runs of `order`: where each starts, and of each emitter in it its run."""

    first: NDArray[np.int64]
    run: NDArray[np.int64]
    order: NDArray[np.int64]

    def least(self, values: FloatArray) -> FloatArray:
        return np.minimum.reduceat(values[self.order], self.first, axis=0)

    def largest(self, values: FloatArray) -> FloatArray:
        return np.maximum.reduceat(values[self.order], self.first, axis=0)

    def total(self, values: FloatArray) -> FloatArray:
        return np.add.reduceat(values[self.order], self.first, axis=0)

    def widest(self, middle: FloatArray) -> FloatArray:
        """Return where emitters lie along what their run extends most in."""
        extent = self.largest(middle) - self.least(middle)
        axis = np.argmax(extent, axis=1)[self.run]
        return np.asarray(middle[self.order][np.arange(len(axis)), axis])


def _nodes(
    runs: _Runs,
    low: FloatArray,
    high: FloatArray,
    area: FloatArray,
    normal: FloatArray,
    two_sided: NDArray[np.bool_],
    power: FloatArray,
) -> FloatArray:
    """Return the nodes of one level, (runs, 3, 4)."""
    least, largest = runs.least(low), runs.largest(high)
    axis = runs.total(normal * power[:, None])
    size = np.linalg.norm(axis, axis=1, keepdims=True)
    axis = np.where(size > 0.0, axis / np.maximum(size, 1e-300), (0.0, 0.0, 1.0))
    cosine = np.einsum("nk,nk->n", normal[runs.order], axis[runs.run])
    cosine[two_sided[runs.order]] = -1.0
    result = np.zeros((len(runs.first), NODE_TEXELS, 4))
    result[:, 0, :3] = 0.5 * (least + largest)
    result[:, 0, 3] = runs.total(area)
    # Wide enough for rounding of the middle.
    result[:, 2, :3] = 0.5 * (largest - least) + _ROUNDING
    result[:, 2, 3] = runs.total(power)
    result[:, 1, :3] = axis
    # A little wider, for rounding, too.
    result[:, 1, 3] = np.clip(np.minimum.reduceat(cosine, runs.first) - 1e-5, -1.0, 1.0)
    return result
