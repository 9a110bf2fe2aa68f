"""Texels that are cut finer: of wide faces where something stands, of all where a lamp ends.

A ground 200 units wide has texels of four, and what a lamp lights under a car would shine from all
of such a texel. So one with something near it that is smaller is cut into a grid of its own, as are
the texels of that: a tree, whose nodes a lookup reads beside the walls on a surfel. So is one that
a lamp is nearer to than the texel is wide, across the lamp's edges: what it lights is seen by
little else than the lamp.
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
from ssdo_gl.raytracing.surfel_points import (
    CLOSE,
    LIFT,
    PARALLEL_COSINE,
    POINT_COUNT,
    texel_points,
)
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
# Light of a lamp changes within so many of its distances to either side of its edges, where parts
# are no wider than this share of the distance, if so many along an edge suffice: 4 bits.
EDGE_REACH, EDGE_SHARE, MOST_EDGE_PARTS = 2.0, 0.75, 15
# Of so many lamps that are flat quads, the largest.
MOST_LAMPS = 256


def graded(surfels: Surfels, bvh: Bvh, most: int, glowing: IntArray) -> Surfels:
    """Return the surfels and at most `most` further ones, which some texels are cut into.

    Parameters
    ----------
    glowing : ndarray, shape (T,)
        Of how many sides each triangle does, from the front on.
    """
    if not (surfels.finest or np.any(glowing)):
        return surfels
    patches = patches_of(bvh)
    least, most_parts = surfels.finest or np.inf, float(MOST_EDGE_PARTS)
    faces = list(_cut_sides(surfels, bvh, patches, glowing))
    while faces:
        cuts = [cut for face in faces for cut in face.cuts(least, most_parts)]
        if sum(len(cut.texels) for cut in cuts) <= most:
            return _appended(surfels, bvh, patches, cuts) if cuts else surfels
        least, most_parts = GROWTH * least, max(most_parts / GROWTH, 1.0)
    return surfels


@dataclass(frozen=True, eq=False)
class _CutSide:
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
    lamps : ndarray, shape (L, 5)
        Of each lamp over it where it begins and ends along both edges, as a part of them, and how
        far off it is.
    """

    patch: int
    side: int
    normal: FloatArray
    first: int
    grid: IntArray
    edges: FloatArray
    at: FloatArray
    widths: FloatArray
    lamps: FloatArray

    def cuts(self, least: float, most_parts: float) -> Iterator[_Cut]:
        """Yield how its texels are cut, widest first, down to about a width of `least`.

        At lamps' edges into `most_parts` at most: were all parts to grow alike, lamps at a
        millimetre would take those of others.
        """
        grid, width, depth = self.grid, self.edges / self.grid, 0
        texels = _places(grid)
        while True:
            is_near = np.zeros(len(texels), dtype=bool)
            if width.max() > COARSER * least:
                is_near = self._near(grid, width)[texels[:, 1], texels[:, 0]]
            wanted = np.where(is_near[:, None], 1, self._at_lamps(texels, width, most_parts))
            depth += 1
            for parts in np.unique(wanted[wanted.max(axis=1) > 1], axis=0):
                rows = np.flatnonzero(np.all(wanted == parts, axis=1))
                yield _Cut(self, rows, parts, grid * parts, _parts(texels[rows], parts), depth)
            rows = np.flatnonzero(is_near)
            if not len(rows):
                return
            finer = max(width.max() / MOST_PARTS, least)
            parts = np.clip(np.rint(width / finer), 1, MOST_PARTS).astype(np.int64)
            texels, grid, width = _parts(texels[rows], parts), grid * parts, width / parts
            yield _Cut(self, rows, parts, grid, texels, depth, is_last=False)

    def _at_lamps(self, texels: IntArray, width: FloatArray, most_parts: float) -> IntArray:
        """Return into how many parts (N, 2) texels are cut along both edges, for lamps' sake."""
        wanted = np.ones((len(texels), 2), dtype=np.int64)
        low = texels * width
        for lamp in self.lamps:
            ends, reach = lamp[:4].reshape(2, 2) * self.edges, EDGE_REACH * lamp[4]
            gaps = np.maximum(low - ends[:, None], ends[:, None] - low - width)
            is_lit = np.all((low < ends[1] + reach) & (low + width > ends[0] - reach), axis=1)
            at_edge = is_lit[:, None] & (gaps.min(axis=0) < reach)
            parts = np.ceil(np.minimum(width / (EDGE_SHARE * lamp[4]), most_parts))
            wanted = np.where(at_edge, np.maximum(wanted, parts.astype(np.int64)), wanted)
        return wanted

    def _near(self, grid: IntArray, width: FloatArray) -> NDArray[np.bool_]:
        """Return which texels of a grid, by rows, something smaller is near to."""
        reach = NEAR * width.max()
        steps = np.ceil(reach / width)
        at = self.at[:, :2] * grid
        chosen = (self.at[:, 2] < reach) & (self.widths * COARSER < width.max())
        chosen &= np.all((at > -steps) & (at < grid + steps), axis=1)
        at, rest = at[chosen], reach**2 - self.at[chosen, 2] ** 2
        # Of a needle, a width along is a million across.
        steps = np.minimum(steps, grid - 1).astype(np.int64)
        texel = np.clip(np.floor(at).astype(np.int64), 0, grid - 1)
        found = np.zeros(grid[::-1], dtype=bool)
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
    is_last : bool
        Its texels are not cut again.
    """

    face: _CutSide
    parents: IntArray
    parts: IntArray
    grid: IntArray
    texels: IntArray
    depth: int
    is_last: bool = True


def _places(grid: IntArray) -> IntArray:
    """Return the texels (N, 2) of a grid, by rows."""
    return np.stack(np.divmod(np.arange(grid.prod()), grid[0])[::-1], axis=1)


def _parts(texels: IntArray, parts: IntArray) -> IntArray:
    """Return the parts (M, 2) of texels (N, 2), texel by texel."""
    return np.asarray((texels[:, None] * parts + _places(parts)).reshape(-1, 2))


def _cut_sides(
    surfels: Surfels, bvh: Bvh, patches: Patches, glowing: IntArray
) -> Iterator[_CutSide]:
    """Yield sides that are not blind whose texels are wider than the finest, or close to lamps."""
    triangle = bvh.primitive_triangles.reshape(-1)[patches.slots[:, 0]]
    first, layout = surfels.places.table[triangle].astype(np.int64).T
    grids, edges = np.stack([layout & 0xFFF, layout >> 12 & 0xFFF], axis=1), patches.extents()
    is_cut, texel = grids.max(axis=1) > 1, (edges / grids).max(axis=1)
    is_wide = is_cut & (surfels.finest > 0.0) & (texel > COARSER * surfels.finest)
    lamps = _lamps_over(patches, glowing[triangle], np.where(is_cut, texel, 0.0))
    if not (is_wide.any() or lamps):
        return
    points = surfels.positions.astype(np.float64)
    widths, middles = np.ptp(points, axis=1).max(axis=1), points.mean(axis=1)
    for patch in sorted({*np.flatnonzero(is_wide).tolist(), *(face // 2 for face in lamps)}):
        grid, corners = grids[patch], patches.corners[patch]
        is_blind = [bool(layout[patch] & flag) for flag in (FRONT_BLIND, BACK_BLIND)]
        for side in range(patches.sides[patch]):
            over = lamps.get(2 * patch + side, [])
            if is_blind[side] or not (is_wide[patch] or over):
                continue
            normal = patches.normals[patch] * (1 - 2 * side)
            height = (middles - corners[0]) @ normal
            # Of a face on which something lies what shows shows beside that.
            is_flat = np.abs(surfels.looks @ normal) > PARALLEL_COSINE
            chosen = height > np.where(is_flat, CLOSE * widths, LIFT)
            chosen &= is_wide[patch] & (widths * COARSER < texel[patch])
            places = _coordinates(corners, bool(patches.is_joint[patch]), middles[chosen])
            at = np.concatenate([places, height[chosen, None]], axis=1)
            fronts = (-(-grid // BLIND_COARSENESS) if is_blind[0] else grid).prod()
            start = first[patch] + side * fronts
            rows = np.array(over).reshape(-1, 5)
            yield _CutSide(patch, side, normal, start, grid, edges[patch], at, widths[chosen], rows)


def _lamps_over(
    patches: Patches, glowing: IntArray, texel: FloatArray
) -> dict[int, list[FloatArray]]:
    """Return `_CutSide.lamps` of sides 2 p + s that flat lamps are nearer to than texels are wide.

    Parameters
    ----------
    glowing, texel : ndarray, shape (N,)
        Of each patch the sides that glow, from the front on, and how wide its texels are.
    """
    found: dict[int, list[FloatArray]] = {}
    flat = np.flatnonzero((glowing > 0) & patches.is_joint)
    corners, normals, centres = patches.corners, patches.normals, patches.centres
    sizes = np.linalg.norm(corners - centres[:, None], axis=2).max(axis=1)
    for lamp in flat[np.argsort(-patches.areas[flat], kind="stable")][:MOST_LAMPS].tolist():
        gap = np.linalg.norm(centres - centres[lamp], axis=1) - sizes - sizes[lamp]
        before = ((corners - centres[lamp]) @ normals[lamp]).max(axis=1) > LIFT
        near = (gap < EDGE_REACH * texel) & (before | (glowing[lamp] > 1)) & (texel > 0.0)
        for patch in np.flatnonzero(near).tolist():
            over = (corners[lamp] - corners[patch, 0]) @ normals[patch]
            for side, height in enumerate((over, -over)[: patches.sides[patch]]):
                off = height.min()
                # At what stands on it light does not change within little.
                if off <= LIFT or EDGE_SHARE * off > texel[patch]:
                    continue
                at = _coordinates(corners[patch], bool(patches.is_joint[patch]), corners[lamp])
                row = np.array([*at.min(axis=0), *at.max(axis=0), off])
                found.setdefault(2 * patch + side, []).append(row)
    return found


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
        wider, begin = wider if cut.is_last else begin, begin + count
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
