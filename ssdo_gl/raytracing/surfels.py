"""Small pieces of the scene's surfaces, each of which keeps the light that reaches it.

Large faces are cut into a grid of texels; small triangles that lie close together and
look the same way share one. The two sides of a surface are two pieces, and so are the two
faces of a thin wall, which look opposite ways.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, IntArray
from ssdo_gl.raytracing.bvh import Bvh
from ssdo_gl.raytracing.packed import oct_words
from ssdo_gl.raytracing.surfel_patches import Patches, patches_of
from ssdo_gl.raytracing.surfel_points import (
    LIFT,
    POINT_COUNT,
    points_of,
    sources_of,
    texel_points,
)

# Cells are shifted by this share of their size, because walls often lie at round numbers,
# where rounding would tear a plane apart.
CELL_SHIFT = 0.37
# A grid has at most so many texels along an edge: 12 bits of a word.
MAX_GRID = 4095
# In the word that holds the size of a grid: the triangle is the first or second of a pair
# that shares it; and by how many corners its order is turned against that of the grid.
FIRST_FLAG, SECOND_FLAG = 1 << 24, 2 << 24
TURN_SHIFT = 26
# In that word: the front, and the back, has a grid of so many times fewer texels along both edges,
# because nothing that matters sees it.
FRONT_BLIND, BACK_BLIND = 1 << 28, 1 << 29
BLIND_COARSENESS = 4
# Others are cut more finely in exchange, by up to as much, where so much of all texels is spared:
# with less they would be a fifth finer at most.
LEAST_SPARED, REFINED_GROWTH = 1.0 / 3.0, 1.05
# A face of one texel across and so many along, as of a slat, has as many across as the limit
# allows of these: sun on its outer edge must not shine from the inner one, which lies in the dark.
STRIP_LENGTH, STRIP_TEXELS = 16, (6, 3, 1)
# By how much texels grow until their number is within the limit.
GROWTH = 1.1
# Where a scene is mostly empty, as a room on a wide ground, its texels would be as large as the
# room. Faces are cut into texels this much smaller, along an edge into no more than of usual
# size have this length, if that leaves them within the limit, and into smaller ones still, in such
# steps and down to this size, as long as there are fewer.
SPARSE_FINENESS, SPARSE_LENGTH, SPARSE_STEP, SPARSE_LEAST = 4.0, 0.95, 2.0**0.5, 5e-4


@dataclass(frozen=True, eq=False)
class Places:
    """Where on a grid of surfels each of T triangles lies.

    Attributes
    ----------
    table : ndarray, shape (T, 2), uint32
        The first surfel of the grid, and its texels along both edges, 12 bits each, with
        `FIRST_FLAG` or `SECOND_FLAG`, and `FRONT_BLIND` and `BACK_BLIND`. Surfels of backs come
        after all those of the front.
    corner : ndarray, shape (T,), int8
        The triangle's corner that is the first one of the grid.
    """

    table: NDArray[np.uint32]
    corner: NDArray[np.int8]

    def of(self, bvh: Bvh) -> NDArray[np.uint32]:
        """Return the table (2 P, 2) for triangles as a hierarchy orders them and their corners.

        Row 2 p + s belongs to triangle s of primitive p.
        """
        chosen = bvh.primitive_triangles.reshape(-1)
        if not len(chosen):
            return np.zeros((1, 2), dtype=np.uint32)
        named = self.table[np.maximum(chosen, 0)]
        first = bvh.primitive_corners.reshape(-1, 3)[:, 0]
        turn = (self.corner[np.maximum(chosen, 0)] - first) % 3
        named[:, 1] |= turn.astype(np.uint32) << TURN_SHIFT
        return named


@dataclass(frozen=True, eq=False)
class Surfels:
    """S surfels of the scene's triangles, in the normalised frame.

    Attributes
    ----------
    positions : ndarray, shape (S, 16, 3), float32
        Points from which rays start, slightly off the surface, on the surfel's side.
    normals : ndarray, shape (S, 16), uint32
        Unit normals there, on the surfel's side, packed as by `oct_words`.
    ends : ndarray, shape (S, 16, 3), float32
        Where eight lines across the surfel begin and end, in turn; slightly off the surface,
        too. They have no length where the surfel is bent.
    looks : ndarray, shape (S, 3), float64
        A unit normal of the surfel, on its side.
    sources : ndarray, shape (S, 16), int32
        The triangle that each point lies on.
    faces : ndarray, shape (S,), int64
        2 p + s for side s of patch p, front 0 and back 1; -1: several patches share it.
    finest : float
        Side of the smallest texels, where those of wide faces are larger; 0: all are alike.
    finer : ndarray, shape (S,), int64
        What the surfel is cut into, 0: nothing. The number of the first, times 256, plus how many
        of them there are along both edges, 4 bits each: as by `graded_surfels.graded`.
    depth : int
        How often one is cut at most.
    """

    positions: NDArray[np.float32]
    normals: NDArray[np.uint32]
    ends: NDArray[np.float32]
    looks: FloatArray
    sources: NDArray[np.int32]
    faces: IntArray
    places: Places
    finest: float
    finer: IntArray
    depth: int = 0

    @property
    def count(self) -> int:
        """Number of surfels."""
        return len(self.positions)

    def lines(self, chosen: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return starts, unit directions (N, 16, 3) and lengths (N, 16) of the lines.

        First all forwards, then all backwards.
        """
        first, last = (self.ends[chosen, i::2].astype(np.float64) for i in (0, 1))
        starts = np.concatenate([first, last], axis=1)
        along = np.concatenate([last, first], axis=1) - starts
        length = np.linalg.norm(along, axis=-1)
        return starts, along / np.maximum(length, np.finfo(np.float64).tiny)[..., None], length


def build_surfels(
    bvh: Bvh,
    most: int,
    smallest: float,
    spare: int = 0,
    sparse: int = 0,
    blind: NDArray[np.bool_] | None = None,
    slats: NDArray[np.bool_] | None = None,
) -> Surfels:
    """Cut the triangles of `bvh` into at most about `most` surfels.

    Parameters
    ----------
    most : int
        Texels grow until there are no more, both sides counted.
    smallest : float
        Side of a texel, normalised frame, below which none is cut.
    spare : int
        By how many there may be more where strips are cut finer.
    sparse : int
        Where texels a quarter as large as `smallest` are no more than `most`, which leaves all but
        scenes that are mostly empty as they are, they are smaller still as long as there are no
        more than this.
    blind : ndarray, shape (N, 2), bool, optional
        Fronts and backs of patches that are cut coarsely, and others more finely in exchange: as
        by `blind_sides.blind_sides` of what this returns without.
    slats : ndarray, shape (N,), bool, optional
        Patches that are cut as strips across their shorter edge, too: as by `slats.slat_faces`.
    """
    if bvh.triangles.count == 0:
        none = np.zeros(1, dtype=np.int64)
        points = np.zeros((1, POINT_COUNT, 3), dtype=np.float32)
        normals = np.zeros((1, POINT_COUNT), dtype=np.uint32)
        places = Places(np.zeros((0, 2), dtype=np.uint32), np.zeros(0, dtype=np.int8))
        sources = np.zeros((1, POINT_COUNT), dtype=np.int32)
        return Surfels(
            points, normals, points, np.zeros((1, 3)), sources, none - 1, places, 0.0, none
        )
    patches = patches_of(bvh)
    extents = patches.extents()
    area = float(np.sum(patches.areas * patches.sides))
    size = max(smallest, (area / most) ** 0.5)
    while True:
        grids = np.clip(np.ceil(extents / size - 1e-6), 1, MAX_GRID).astype(np.int64)
        shared = _cells(patches, grids, size)
        if _texel_count(patches, grids) + shared.count <= most or size > 1.0:
            break
        size *= GROWTH
    finer = _finer(patches, extents, grids, size, most, sparse) if sparse else None
    grids, shared, finest = finer or (grids, shared, 0.0)
    coarse = np.zeros((len(grids), 2), dtype=bool)
    blind = None if blind is None else blind[: len(grids)]
    if blind is not None and (cut := _refined(patches, extents, grids, size, shared, blind)):
        (grids, shared), coarse = cut, blind
    is_strip = grids.max(axis=1, keepdims=True) >= STRIP_LENGTH * grids
    if slats is not None:
        is_shorter = extents < extents.max(axis=1, keepdims=True)
        is_strip |= slats[: len(grids), None] & is_shorter & (grids.max(axis=1, keepdims=True) > 1)
    cuts = (np.where(is_strip, np.maximum(grids, across), grids) for across in STRIP_TEXELS)
    room = most + spare - shared.count
    grids = next((cut for cut in cuts if _texel_count(patches, cut, coarse) <= room), grids)
    return _assemble(bvh, patches, grids, coarse, shared, finest)


def _finer(
    patches: Patches, extents: FloatArray, grids: IntArray, size: float, most: int, sparse: int
) -> tuple[IntArray, _Shared, float] | None:
    """Return finer grids (N, 2) as `build_surfels` says; None if the scene is not sparse."""
    size, along, found = size / SPARSE_FINENESS, np.ceil(SPARSE_LENGTH / size), None
    while size >= SPARSE_LEAST:
        finer = np.clip(np.ceil(extents / size - 1e-6), 1, along).astype(np.int64)
        finer = np.maximum(grids, finer)
        # Asked first: of many patches the cells take long.
        room = (min(sparse, most) if found else most) - _texel_count(patches, finer)
        if room < 0 or (shared := _cells(patches, finer, size)).count > room:
            break
        found, size = (finer, shared, size), size / SPARSE_STEP
    return found


def _refined(
    patches: Patches,
    extents: FloatArray,
    grids: IntArray,
    size: float,
    shared: _Shared,
    blind: NDArray[np.bool_],
) -> tuple[IntArray, _Shared] | None:
    """Return finer grids (N, 2) of no more surfels, blind sides cut coarsely; None: few are."""
    most = _texel_count(patches, grids) + shared.count
    left = _texel_count(patches, grids, blind) + shared.count
    if left > (1.0 - LEAST_SPARED) * most:
        return None
    largest = size
    size *= max((left / most) ** 0.5, 1.0 / BLIND_COARSENESS)
    while size < largest:
        finer = np.clip(np.ceil(extents / size - 1e-6), 1, MAX_GRID).astype(np.int64)
        finer = np.maximum(grids, finer)
        # Asked first: of many patches the cells take long.
        room = most - _texel_count(patches, finer, blind)
        if room >= 0 and (cells := _cells(patches, finer, size)).count <= room:
            return finer, cells
        size *= REFINED_GROWTH
    return None


def _cuts(grids: IntArray, coarse: NDArray[np.bool_]) -> IntArray:
    """Return the grids of both sides, (N, 2, 2), of patches with grids (N, 2)."""
    return np.where(coarse[..., None], -(-grids // BLIND_COARSENESS)[:, None], grids[:, None])


def _texel_count(patches: Patches, grids: IntArray, coarse: NDArray[np.bool_] | None = None) -> int:
    """Return how many surfels the grids (N, 2) have of more than one texel."""
    own = grids.max(axis=1) > 1
    if coarse is None:
        return int(np.sum((grids.prod(axis=1) * patches.sides)[own]))
    return int(_side_counts(patches, _cuts(grids, coarse))[own].sum())


def _side_counts(patches: Patches, cuts: IntArray) -> IntArray:
    """Return how many texels (N, 2) each side has."""
    counts = cuts.prod(axis=2)
    counts[patches.sides == 1, 1] = 0
    return np.asarray(counts)


@dataclass(frozen=True, eq=False)
class _Shared:
    """Small patches by the surfel that they share."""

    patches: IntArray  # sorted by group
    group: IntArray  # of each of `patches`, from 0
    sides: IntArray  # of each group

    @property
    def count(self) -> int:
        """Number of surfels."""
        return int(self.sides.sum())


def _cells(patches: Patches, grids: IntArray, size: float) -> _Shared:
    """Group the patches of a single texel by place and by where they look."""
    small = np.flatnonzero(grids.max(axis=1) == 1)
    cell = np.floor(patches.centres[small] / size + CELL_SHIFT).astype(np.int64)
    # 16 bits are enough for cells of any size that `build_surfels` comes to.
    key = patches.sides[small]
    for axis in range(3):
        key = (key << 16) + (cell[:, axis] & 0xFFFF)
    key = key * 27 + patches.looks[small]
    order = np.argsort(key, kind="stable")
    starts = np.ones(len(order), dtype=bool)
    starts[1:] = key[order][1:] != key[order][:-1]
    chosen = small[order]
    return _Shared(chosen, np.cumsum(starts) - 1, patches.sides[chosen[starts]])


def _assemble(
    bvh: Bvh,
    patches: Patches,
    grids: IntArray,
    coarse: NDArray[np.bool_],
    shared: _Shared,
    finest: float,
) -> Surfels:
    own = np.flatnonzero(grids.max(axis=1) > 1)
    cuts = _cuts(grids, coarse)
    counts = _side_counts(patches, cuts)[own]
    firsts = np.cumsum(counts.sum(axis=1)) - counts.sum(axis=1)
    own_count = int(counts.sum())
    shared_firsts = own_count + np.cumsum(shared.sides) - shared.sides
    total = own_count + shared.count
    triangle = bvh.primitive_triangles.reshape(-1)[patches.slots]
    firsts_of = np.zeros(len(grids), dtype=np.int64)
    firsts_of[own], firsts_of[shared.patches] = firsts, shared_firsts[shared.group]
    places = _places(bvh, patches, grids, coarse, firsts_of)
    sources = np.zeros((total, POINT_COUNT), dtype=np.int32)
    positions = np.zeros((total, POINT_COUNT, 3))
    ends = np.zeros((total, POINT_COUNT, 3))
    normals = np.zeros((total, POINT_COUNT, 3))
    faces = np.full(total, -1, dtype=np.int64)
    rng = np.random.default_rng(0)

    def fill_sheets(side: int, chosen: NDArray[np.bool_]) -> IntArray:
        """Fill in the texels of one side of the chosen patches; return their numbers."""
        cells = counts[chosen, side]
        patch = np.repeat(own[chosen], cells)
        within = np.arange(len(patch)) - np.repeat(np.cumsum(cells) - cells, cells)
        cut = cuts[patch, side]
        low = np.stack([within % cut[:, 0], within // cut[:, 0]], axis=1)
        at = np.repeat(firsts[chosen] + side * counts[chosen, 0], cells) + within
        positions[at], ends[at], sources[at] = texel_points(rng, patches, triangle, patch, low, cut)
        normals[at] = patches.normals[patch, None] * (1 - 2 * side)
        faces[at] = 2 * patch + side
        return np.asarray(at)

    # Both sides have the same points, unless they are cut differently.
    is_alike = coarse[own, 0] == coarse[own, 1]
    front = fill_sheets(0, np.ones(len(own), dtype=bool))
    fill_sheets(1, (patches.sides[own] == 2) & ~is_alike)
    front = front[np.repeat(is_alike & (patches.sides[own] == 2), counts[:, 0])]
    behind = np.repeat(counts[:, 0], counts[:, 0])
    behind = behind[np.repeat(is_alike & (patches.sides[own] == 2), counts[:, 0])]
    back = front + behind
    faces[back] = faces[front] + 1
    # Shared ones: points by area.
    if len(shared.patches):
        chosen, u = _drawn(rng, patches, shared)
        at, look = points_of(patches, chosen, u), patches.normals[chosen]
        positions[shared_firsts], normals[shared_firsts] = at, look
        sources[shared_firsts] = sources_of(patches, triangle, chosen, u)
        height = np.einsum("spk,sk->sp", at - at[:, :1], look[:, 0])
        is_flat = np.abs(height).max(axis=1) < LIFT
        ends[shared_firsts] = np.where(is_flat[:, None, None], at, at[:, :1])
        has_back = shared_firsts[shared.sides == 2]
        front, back = np.concatenate([front, has_back]), np.concatenate([back, has_back + 1])
    positions[back], ends[back], normals[back] = positions[front], ends[front], -normals[front]
    sources[back] = sources[front]
    points, line_ends = ((at + LIFT * normals).astype(np.float32) for at in (positions, ends))
    words, whole = oct_words(normals), np.zeros(total, dtype=np.int64)
    return Surfels(points, words, line_ends, normals[:, 0], sources, faces, places, finest, whole)


def _places(
    bvh: Bvh, patches: Patches, grids: IntArray, coarse: NDArray[np.bool_], firsts: IntArray
) -> Places:
    """Return the grid of each triangle: those of `patches`, which begin at `firsts`."""
    table = np.zeros((bvh.triangles.count, 2), dtype=np.uint32)
    corner = np.zeros(bvh.triangles.count, dtype=np.int8)
    size = grids[:, 0] | grids[:, 1] << 12 | coarse @ np.array([FRONT_BLIND, BACK_BLIND])
    for slot, flag in zip(patches.slots.T, (FIRST_FLAG, SECOND_FLAG), strict=True):
        triangle = bvh.primitive_triangles.reshape(-1)[slot]
        table[triangle] = np.stack([firsts, size | np.where(patches.is_joint, flag, 0)], axis=1)
        corner[triangle] = bvh.primitive_corners.reshape(-1, 3)[slot, 0]
    return Places(table, corner)


def _drawn(
    rng: np.random.Generator, patches: Patches, shared: _Shared
) -> tuple[IntArray, FloatArray]:
    """Return for each group 16 patches, drawn by area, and a point of each one's grid."""
    areas = np.maximum(patches.areas[shared.patches], np.finfo(np.float64).tiny)
    total = np.cumsum(areas)
    group_count = len(shared.sides)
    last = np.searchsorted(shared.group, np.arange(group_count), side="right") - 1
    first = np.searchsorted(shared.group, np.arange(group_count))
    low, high = (total - areas)[first], total[last]
    k = (np.arange(POINT_COUNT) + rng.uniform(0.1, 0.9, (group_count, POINT_COUNT))) / POINT_COUNT
    at = np.searchsorted(total, low[:, None] + k * (high - low)[:, None])
    at = np.clip(at, first[:, None], last[:, None])
    u = rng.uniform(0.05, 0.95, (group_count, POINT_COUNT, 2))
    chosen = shared.patches[at]
    single = ~patches.is_joint[chosen]
    u[..., 0] = np.where(single, np.sqrt(u[..., 0]), u[..., 0])
    return chosen, u
