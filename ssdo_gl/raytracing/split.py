"""Binary bounding-volume hierarchy by binned surface-area heuristic, one level at a time.

All nodes of a level are split together by NumPy reductions, so no Python loop runs
per node or per primitive. Source of the heuristic: Wald, "On fast Construction of
SAH-based Bounding Volume Hierarchies" (2007).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, IntArray

BoxArray = NDArray[np.float32] | NDArray[np.float64]

# 16 bins cost 1 % more rays' work than 64 and a quarter of the build time (Wald 2007).
BIN_COUNT = 16
# Of nodes with no more members the planes between these are looked at instead of all bins.
MOST_FEW = 6
# Of more boxes, those in one cell of a grid, some eight, are one until a node has no more
# than MOST_CELLS of them. Rays then cross 0.0 to 1.5 % more surface of nodes (four scenes of
# 9 000 to 300 000 pairs), 0.0 to 1.1 % with 64 cells.
MOST_EXACT = 1 << 20
CELL_MEMBERS, MOST_CELLS = 8, 16
# Bits of a Morton code for each axis, and what spreads them.
MORTON_BITS = 21
MORTON_STEPS = 1 << MORTON_BITS
MORTON_MASKS = (
    (32, 0x1F00000000FFFF),
    (16, 0x1F0000FF0000FF),
    (8, 0x100F00F00F00F00F),
    (4, 0x10C30C30C30C30C3),
    (2, 0x1249249249249249),
)
# Nodes are binned in groups, so that the tables of one group stay within some 20 MB.
GROUP_SIZE = 8192
# Below this level the split is by count: however uneven the input, the depth, and with
# it the shader's stack, stays below this many levels plus log2 of the primitive count.
MAX_SAH_DEPTH = 40


Report = Callable[[float], None]


def ignored(_share: float) -> None:
    """Tell nobody how far a work is."""


@dataclass(frozen=True, eq=False)
class BinaryTree:
    """A binary hierarchy over boxes; node 0 is the root, a leaf holds one primitive.

    Attributes
    ----------
    low, high : ndarray, shape (N, 3), float32 or float64
    left : ndarray, shape (N,), int64
        First child; the second is ``left + 1``. -1 for a leaf.
    primitive : ndarray, shape (N,), int64
        The leaf's primitive, -1 for an inner node.
    level_starts : ndarray, shape (D + 1,), int64
        Nodes level_starts[i] up to level_starts[i + 1] are i levels below the root.
    """

    low: BoxArray
    high: BoxArray
    left: IntArray
    primitive: IntArray
    level_starts: IntArray


def half_area(low: BoxArray, high: BoxArray) -> FloatArray:
    """Return half the surface area of boxes (..., 3); 0 for empty (inverted) ones."""
    extent = np.subtract(high, low, dtype=np.float64)
    x, y, z = np.moveaxis(np.maximum(extent, 0.0), -1, 0)
    return np.asarray(x * y + y * z + z * x)


def build_binary(low: BoxArray, high: BoxArray, report: Report = ignored) -> BinaryTree:
    """Build the hierarchy over P boxes.

    Of very many, those that lie together are one until few of them are left in a node.

    Parameters
    ----------
    low, high : ndarray, shape (P, 3), float32 or float64
        P >= 1.
    report : callable
        Told which share of the work is done, [0, 1].
    """
    count = len(low)
    place = np.arange(count)
    growing = _Growing(count, low.dtype, report)
    nodes = np.zeros(1, dtype=np.int64), place, np.array([count])
    if count > MOST_EXACT:
        code = morton_codes(low, high)
        place = np.argsort(code)
        low, high = low[place], high[place]
        starts = _cell_starts(code[place])
        members = np.diff(np.append(starts, count))
        cells = _Parts(
            np.minimum.reduceat(low, starts, axis=0),
            np.maximum.reduceat(high, starts, axis=0),
            members,
        )
        ids, order, counts = growing.grow(
            np.zeros(1, dtype=np.int64),
            np.arange(len(starts)),
            np.array([len(starts)]),
            cells,
            MOST_CELLS,
        )
        nodes = ids, *_members_of_cells(order, counts, starts, members)
    ids, order, _ = growing.grow(*nodes, _Parts(low, high, None), 1)
    growing.primitive[ids] = place[order]
    return growing.tree()


def morton_codes(low: BoxArray, high: BoxArray) -> NDArray[np.uint64]:
    """Return numbers (P,) in the order of which boxes (P, 3) lie near one another."""
    code = np.zeros(len(low), dtype=np.uint64)
    for axis in range(3):
        along = low[:, axis] + high[:, axis]
        first, last = float(along.min()), float(along.max())
        steps = MORTON_STEPS / max(last - first, float(np.finfo(np.float32).tiny))
        bits = np.minimum((along - first) * steps, MORTON_STEPS - 1).astype(np.uint64)
        # Two zeros between any two bits (Karras 2012).
        for shift, mask in MORTON_MASKS:
            bits = (bits | bits << np.uint64(shift)) & np.uint64(mask)
        code |= bits << np.uint64(axis)
    return code


def _cell_starts(code: NDArray[np.uint64]) -> IntArray:
    """Return where the cells of a grid begin in sorted codes, some `CELL_MEMBERS` in each."""
    starts = np.zeros(1, dtype=np.int64)
    for level in range(1, MORTON_BITS + 1):
        cell = code >> np.uint64(3 * (MORTON_BITS - level))
        finer = np.flatnonzero(np.concatenate([[True], cell[1:] != cell[:-1]]))
        if len(finer) * CELL_MEMBERS > len(code):
            break
        starts = finer
    return starts


def _members_of_cells(
    order: IntArray, counts: IntArray, starts: IntArray, weight: IntArray
) -> tuple[IntArray, IntArray]:
    """Return the members of nodes that consist of cells, node after node, and their numbers."""
    lengths = weight[order]
    offset = starts[order] - (np.cumsum(lengths) - lengths)
    members = np.repeat(offset, lengths) + np.arange(int(lengths.sum()))
    return members, np.add.reduceat(lengths, np.cumsum(counts) - counts)


@dataclass(frozen=True, eq=False)
class _Parts:
    """What nodes are made of: boxes (P, 3), and how many primitives each stands for, or 1."""

    low: BoxArray
    high: BoxArray
    weight: IntArray | None


class _Growing:
    """A tree while it grows downwards, a level at a time."""

    def __init__(self, count: int, kind: np.dtype[Any], report: Report) -> None:
        self._report = report
        self.low, self.high = np.empty((2, 2 * count - 1, 3), dtype=kind)
        self.left = np.full(2 * count - 1, -1, dtype=np.int64)
        self.primitive = np.full(2 * count - 1, -1, dtype=np.int64)
        self._level_starts = [0]
        self._used = 1

    def tree(self) -> BinaryTree:
        starts = np.array([*self._level_starts, self._used])
        return BinaryTree(self.low, self.high, self.left, self.primitive, starts)

    def grow(
        self, ids: IntArray, order: IntArray, counts: IntArray, boxes: _Parts, fewest: int
    ) -> tuple[IntArray, IntArray, IntArray]:
        """Split nodes until none has more than `fewest` boxes; return those left, as given.

        Parameters
        ----------
        ids, counts : ndarray, shape (N,)
            The nodes and how many boxes each holds.
        order : ndarray, shape (sum of counts,)
            Their boxes, node after node.
        """
        kept: list[tuple[IntArray, IntArray, IntArray]] = []
        while True:
            starts = np.cumsum(counts) - counts
            for axis in range(3):
                self.low[ids, axis] = np.minimum.reduceat(boxes.low[order, axis], starts)
                self.high[ids, axis] = np.maximum.reduceat(boxes.high[order, axis], starts)
            is_done = counts <= fewest
            in_done = np.repeat(is_done, counts)
            kept.append((ids[is_done], order[in_done], counts[is_done]))
            if is_done.all():
                found = (np.concatenate(arrays) for arrays in zip(*kept, strict=True))
                return next(found), next(found), next(found)
            inner = ids[~is_done]
            self.left[inner] = self._used + 2 * np.arange(len(inner))
            ids = np.arange(self._used, self._used + 2 * len(inner))
            depth = len(self._level_starts)
            order, counts = _split_level(order[~in_done], counts[~is_done], boxes, depth)
            # Levels take the same time each, and double what there is.
            self._report(float(np.log2(self._used) / np.log2(len(self.left))))
            self._level_starts.append(self._used)
            self._used += len(ids)


def _split_level(
    order: IntArray, counts: IntArray, boxes: _Parts, depth: int
) -> tuple[IntArray, IntArray]:
    """Split every node of a level in two; return the new order and child counts."""
    ends = np.cumsum(counts)
    goes_right = np.empty(len(order), dtype=bool)
    for group in range(0, len(counts), GROUP_SIZE):
        chosen = counts[group : group + GROUP_SIZE]
        stop = ends[min(group + GROUP_SIZE, len(counts)) - 1]
        span = slice(ends[group] - counts[group], stop)
        members = order[span]
        if depth < MAX_SAH_DEPTH:
            weight = None if boxes.weight is None else boxes.weight[members]
            side = _choose_sides(chosen, boxes.low[members], boxes.high[members], weight)
        else:
            side = np.zeros(len(members), dtype=bool)
        goes_right[span] = _halve_unsplit(side, chosen)

    starts = ends - counts
    right_before = np.cumsum(goes_right)
    right_before -= goes_right
    of_node = right_before[starts]
    right_count = np.append(of_node[1:], right_before[-1] + goes_right[-1]) - of_node
    left_count = counts - right_count
    right_before -= np.repeat(of_node, counts)
    # To the right: behind all that go left. To the left: as many places back as went right.
    target = np.where(
        goes_right,
        np.repeat(starts + left_count, counts) + right_before,
        np.arange(len(order)) - right_before,
    )
    result = np.empty_like(order)
    result[target] = order
    return result, np.stack([left_count, right_count], axis=1).reshape(-1)


def _halve_unsplit(side: NDArray[np.bool_], counts: IntArray) -> NDArray[np.bool_]:
    """Split nodes that the heuristic left whole (coincident centres) by count."""
    starts = np.cumsum(counts) - counts
    right = np.add.reduceat(side.astype(np.int64), starts)
    whole = (right == 0) | (right == counts)
    node = np.repeat(np.arange(len(counts)), counts)
    second_half = np.arange(len(side)) - starts[node] >= (counts // 2)[node]
    return np.asarray(np.where(whole[node], second_half, side))


def _choose_sides(
    counts: IntArray,
    low: BoxArray,
    high: BoxArray,
    weight: IntArray | None,
) -> NDArray[np.bool_]:
    """Return, for the members of consecutive nodes, whether they go to the right child."""
    node_count = len(counts)
    starts = np.cumsum(counts) - counts
    best_cost = np.full(node_count, np.inf)
    side = np.zeros(len(low), dtype=bool)
    # Nodes by the number of their members, where these are few and count alike.
    most_few = MOST_FEW if weight is None else 0
    few = [(np.flatnonzero(counts == count), count) for count in range(2, most_few + 1)]
    members_of = [starts[chosen] + np.arange(count)[:, None] for chosen, count in few]
    boxes_of = [(low[members], high[members]) for members in members_of]
    many = np.flatnonzero(counts > most_few)
    in_many = np.repeat(counts > most_few, counts)
    many_low, many_high = low[in_many], high[in_many]
    many_weight = None if weight is None else weight[in_many]
    many_key = np.repeat(np.arange(len(many)) * BIN_COUNT, counts[many])
    for axis in range(3):
        along = 0.5 * np.add(low[:, axis], high[:, axis], dtype=np.float64)
        first = np.minimum.reduceat(along, starts)
        extent = np.maximum.reduceat(along, starts) - first
        # A zero extent puts all members into bin 0: infinite cost, so never chosen.
        per_unit = np.divide(BIN_COUNT, extent, out=np.zeros(node_count), where=extent > 0.0)
        along -= np.repeat(first, counts)
        along *= np.repeat(per_unit, counts)
        slot = np.minimum(along.astype(np.int64), BIN_COUNT - 1)
        cost, split = np.empty(node_count), np.empty(node_count, dtype=np.int64)
        for (chosen, _), members, boxes in zip(few, members_of, boxes_of, strict=True):
            cost[chosen], split[chosen] = _best_plane_of_few(slot[members], *boxes)
        if len(many):
            cost[many], split[many] = _best_plane(
                many_key + slot[in_many], len(many), many_low, many_high, many_weight
            )
        better = cost < best_cost
        best_cost = np.where(better, cost, best_cost)
        mine = np.repeat(better, counts)
        side[mine] = (slot > np.repeat(split, counts))[mine]
    return side


def _best_plane_of_few(
    slot: IntArray, low: BoxArray, high: BoxArray
) -> tuple[FloatArray, IntArray]:
    """Return what `_best_plane` does, of nodes with as many members each.

    Only the plane behind a bin that holds a member can be the first of least cost, and
    members are fewer than bins.

    Parameters
    ----------
    slot : ndarray, shape (K, N)
        Bins of the members.
    low, high : ndarray, shape (K, N, 3)
    """
    count = len(slot)
    rows = np.arange(slot.shape[1])
    order = np.argsort(slot, axis=0, kind="stable")
    slot, low, high = slot[order, rows], low[order, rows], high[order, rows]
    right_low, right_high = low.copy(), high.copy()
    for member in range(1, count):
        np.minimum(low[member], low[member - 1], out=low[member])
        np.maximum(high[member], high[member - 1], out=high[member])
        back = count - 1 - member
        np.minimum(right_low[back], right_low[back + 1], out=right_low[back])
        np.maximum(right_high[back], right_high[back + 1], out=right_high[back])
    before = np.arange(1, count)[:, None]
    cost = half_area(low[:-1], high[:-1]) * before
    cost += half_area(right_low[1:], right_high[1:]) * (count - before)
    cost[slot[1:] == slot[:-1]] = np.inf
    best = np.argmin(cost, axis=0)
    return cost[best, rows], slot[best, rows]


def _best_plane(
    key: IntArray,
    node_count: int,
    low: BoxArray,
    high: BoxArray,
    weight: IntArray | None,
) -> tuple[FloatArray, IntArray]:
    """Return each node's least cost along one axis and the last bin of its left side."""
    shape = (node_count, BIN_COUNT)
    size = node_count * BIN_COUNT
    members = np.bincount(key, weight, minlength=size).reshape(shape)
    flat_low = np.full((3, size), np.inf, dtype=low.dtype)
    flat_high = np.full((3, size), -np.inf, dtype=low.dtype)
    for axis in range(3):
        np.minimum.at(flat_low[axis], key, low[:, axis])
        np.maximum.at(flat_high[axis], key, high[:, axis])
    bin_low, bin_high = flat_low.reshape(3, *shape), flat_high.reshape(3, *shape)

    def swept_cost(reverse: bool) -> FloatArray:
        step = slice(None, None, -1 if reverse else 1)
        lows = np.minimum.accumulate(bin_low[..., step], axis=2)
        highs = np.maximum.accumulate(bin_high[..., step], axis=2)
        total = np.cumsum(members[:, step], axis=1)
        # Empty sides have inverted infinite boxes; their difference is -inf, clamped to 0.
        area = half_area(np.moveaxis(lows, 0, -1), np.moveaxis(highs, 0, -1))
        return np.asarray(np.where(total > 0, area * total, np.inf)[:, step])

    # Plane i lies between bin i and bin i + 1.
    cost = swept_cost(False)[:, :-1] + swept_cost(True)[:, 1:]
    split = np.argmin(cost, axis=1)
    return cost[np.arange(node_count), split], split
