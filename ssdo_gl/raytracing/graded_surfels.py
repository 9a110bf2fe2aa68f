"""Texels of wide faces that are cut finer where something stands on them, or near them.

A ground 200 units wide has texels of four, and what a lamp lights under a car would shine from all
of such a texel. So one with something near it that is smaller is cut into a grid of its own, as are
the texels of that: a tree, whose nodes a lookup reads beside the walls on a surfel.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, IntArray
from ssdo_gl.raytracing.bvh import Bvh
from ssdo_gl.raytracing.packed import oct_words
from ssdo_gl.raytracing.surfel_patches import Patches, patches_of
from ssdo_gl.raytracing.surfel_points import LIFT, POINT_COUNT, texel_points
from ssdo_gl.raytracing.surfels import BACK_BLIND, BLIND_COARSENESS, FRONT_BLIND, Surfels

# Texels that are cut have so many parts along an edge, at most: 4 bits, and a lookup fetches once
# for each cut. With 2 or 3 of them scenes err as with 4.
MOST_PARTS = 4
PARTS_SHIFT, FINER_SHIFT = 4, 8
# A texel is cut if something is less than so many of its widths away. With 3 there are 1.7 times as
# many, and scenes err as before.
NEAR = 1.5
# What is near is smaller than a texel by this factor, or the texel stays whole.
COARSER = 1.5
# By how much the finest texels grow until there are not too many.
GROWTH = 2.0**0.5
# What is parallel to a face, within 8 degrees, and closer than so much of its width lies on it
# (`CLOSE` of passes/surfel_covers.frag): what shows of the face shows beside it.
PARALLEL_COSINE, CLOSE = 0.99, 0.05


def graded(surfels: Surfels, bvh: Bvh, most: int) -> Surfels:
    """Return the surfels and at most `most` further ones, which wide texels are cut into."""
    if not surfels.finest:
        return surfels
    patches = patches_of(bvh)
    faces, least = list(_wide_sides(surfels, bvh, patches)), surfels.finest
    while True:
        cuts = [cut for face in faces for cut in face.cuts(least)]
        if sum(len(cut.texels) for cut in cuts) <= most:
            return _appended(surfels, bvh, patches, cuts) if cuts else surfels
        least *= GROWTH


@dataclass(frozen=True, eq=False)
class _WideSide:
    """One side of a patch, and what stands before it.

    Attributes
    ----------
    normal : ndarray, shape (3,)
        Unit, on its side.
    first : int
        The surfel that its first texel is.
    grid, edges : ndarray, shape (2,)
        How many it has along both edges, and how long these are.
    at : ndarray, shape (N, 3)
        Where other surfels are: along both edges, as a part of them, and how far off.
    widths : ndarray, shape (N,)
        Of these.
    """

    patch: int
    side: int
    normal: FloatArray
    first: int
    grid: IntArray
    edges: FloatArray
    at: FloatArray
    widths: FloatArray

    def cuts(self, least: float) -> Iterator[_Cut]:
        """Yield how its texels are cut, widest first, down to about a width of `least`."""
        grid, width, depth = self.grid, self.edges / self.grid, 0
        texels = np.stack(np.divmod(np.arange(grid.prod()), grid[0])[::-1], axis=1)
        while width.max() > COARSER * least:
            chosen = np.flatnonzero(self._near(grid, width)[texels[:, 1], texels[:, 0]])
            if not len(chosen):
                return
            finer = max(width.max() / MOST_PARTS, least)
            parts = np.clip(np.rint(width / finer), 1, MOST_PARTS).astype(np.int64)
            part = np.stack(np.divmod(np.arange(parts.prod()), parts[0])[::-1], axis=1)
            texels = (texels[chosen, None] * parts + part).reshape(-1, 2)
            grid, width, depth = grid * parts, width / parts, depth + 1
            yield _Cut(self, chosen, parts, grid, texels, depth)

    def _near(self, grid: IntArray, width: FloatArray) -> NDArray[np.bool_]:
        """Return which texels of a grid, by rows, something smaller is near to."""
        reach = NEAR * width.max()
        steps = np.ceil(reach / width).astype(np.int64)
        at = self.at[:, :2] * grid
        chosen = (self.at[:, 2] < reach) & (self.widths * COARSER < width.max())
        chosen &= np.all((at > -steps) & (at < grid + steps), axis=1)
        at, rest = at[chosen], reach**2 - self.at[chosen, 2] ** 2
        texel, found = np.floor(at).astype(np.int64), np.zeros(grid[::-1], dtype=bool)
        for step in np.ndindex(*(2 * steps + 1)):
            low = texel + step - steps
            gap = np.maximum(np.maximum(low - at, at - low - 1), 0.0) * width
            hit = ((gap**2).sum(axis=1) < rest) & np.all((low >= 0) & (low < grid), axis=1)
            found[low[hit, 1], low[hit, 0]] = True
        return found


@dataclass(frozen=True, eq=False)
class _Cut:
    """Texels of a face that are cut alike.

    Attributes
    ----------
    parents : ndarray, shape (N,)
        Which of the texels of the next wider cut of the face, or of its grid.
    parts : ndarray, shape (2,)
        How many each has along both edges.
    grid : ndarray, shape (2,)
        How many such parts all of the face would have.
    texels : ndarray, shape (M, 2)
        Which of those there are, parent by parent.
    depth : int
        The how manyth cut of the face it is: 1 is the widest.
    """

    face: _WideSide
    parents: IntArray
    parts: IntArray
    grid: IntArray
    texels: IntArray
    depth: int


def _wide_sides(surfels: Surfels, bvh: Bvh, patches: Patches) -> Iterator[_WideSide]:
    """Yield the sides of patches whose texels are wider than the finest, but for blind ones."""
    triangle = bvh.primitive_triangles.reshape(-1)[patches.slots[:, 0]]
    first, layout = surfels.places.table[triangle].astype(np.int64).T
    grids, edges = np.stack([layout & 0xFFF, layout >> 12 & 0xFFF], axis=1), patches.extents()
    is_wide = (edges / grids).max(axis=1) > COARSER * surfels.finest
    points = surfels.positions.astype(np.float64)
    widths, middles = np.ptp(points, axis=1).max(axis=1), points.mean(axis=1)
    for patch in np.flatnonzero(is_wide & (grids.max(axis=1) > 1)).tolist():
        grid, corners = grids[patch], patches.corners[patch]
        is_blind = [bool(layout[patch] & flag) for flag in (FRONT_BLIND, BACK_BLIND)]
        for side in range(patches.sides[patch]):
            if is_blind[side]:
                continue
            normal = patches.normals[patch] * (1 - 2 * side)
            height = (middles - corners[0]) @ normal
            is_flat = np.abs(surfels.looks @ normal) > PARALLEL_COSINE
            chosen = height > np.where(is_flat, CLOSE * widths, LIFT)
            chosen &= widths * COARSER < (edges[patch] / grid).max()
            places = _coordinates(corners, bool(patches.is_joint[patch]), middles[chosen])
            at = np.concatenate([places, height[chosen, None]], axis=1)
            fronts = (-(-grid // BLIND_COARSENESS) if is_blind[0] else grid).prod()
            start = first[patch] + side * fronts
            yield _WideSide(patch, side, normal, start, grid, edges[patch], at, widths[chosen])


def _coordinates(corners: FloatArray, is_joint: bool, points: FloatArray) -> FloatArray:
    """Return where points (N, 3) over a patch lie on its grid, along both edges, of 1, (N, 2)."""
    v0, v1, v2, v3 = corners
    b, c = _weights(points - v0, v1 - v0, v2 - v0)
    if not is_joint:
        # Next to the corner all places across are one.
        outward = np.maximum(b + c, LIFT)
        return np.stack([outward, np.clip(c / outward, 0.0, 1.0)], axis=1)
    inner, outer = _weights(points - v0, v2 - v0, v3 - v0)
    first, second = np.stack([b + c, c], axis=1), np.stack([inner, inner + outer], axis=1)
    return np.where((b >= 0.0)[:, None], first, second)


def _weights(points: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Return what multiples (2, N) of two vectors points are the sum of, but for their height."""
    normal = np.cross(b, c)
    across = np.stack([np.cross(c, normal), np.cross(normal, b)])
    return np.asarray(across @ points.T / (normal @ normal))


def _appended(surfels: Surfels, bvh: Bvh, patches: Patches, cuts: list[_Cut]) -> Surfels:
    """Return the surfels and those that some of them are cut into."""
    rng, triangle = np.random.default_rng(1), bvh.primitive_triangles.reshape(-1)[patches.slots]
    begin, wider = surfels.count, 0
    finer = np.zeros(begin + sum(len(cut.texels) for cut in cuts), dtype=np.int64)
    made = []
    for cut in cuts:
        face, count = cut.face, len(cut.texels)
        firsts = begin + np.arange(0, count, cut.parts.prod())
        wider = face.first if cut.depth == 1 else wider
        parts = cut.parts[1] << PARTS_SHIFT | cut.parts[0]
        finer[wider + cut.parents] = firsts << FINER_SHIFT | parts
        wider, begin = begin, begin + count
        patch, grid = np.full(count, face.patch), np.tile(cut.grid, (count, 1))
        placed = texel_points(rng, patches, triangle, patch, cut.texels, grid)
        normals = np.tile(face.normal, (count, POINT_COUNT, 1))
        made.append((*placed, normals, 2 * patch + face.side))
    at, ends, sources, normals, faces = (np.concatenate(part) for part in zip(*made, strict=True))
    points, lines = ((p + LIFT * normals).astype(np.float32) for p in (at, ends))
    lines = np.concatenate([surfels.ends, lines])
    # What stands on a texel that is cut stands on its parts.
    lines[finer > 0] = lines[finer > 0, :1]
    return replace(
        surfels,
        positions=np.concatenate([surfels.positions, points]),
        normals=np.concatenate([surfels.normals, oct_words(normals)]),
        ends=lines,
        looks=np.concatenate([surfels.looks, normals[:, 0]]),
        sources=np.concatenate([surfels.sources, sources]),
        faces=np.concatenate([surfels.faces, faces]),
        finer=finer,
        depth=max(cut.depth for cut in cuts),
    )
