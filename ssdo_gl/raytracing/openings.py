"""Openings through which a room sees the sky: rectangles that its open rays pass.

Six rays a pixel seldom find a small window. Nothing says where one is but the rays that leave:
they come from everywhere in the room, and all pass it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray
from ssdo_gl.raytracing.packed import unit_vectors

# At most so many, and fewer rays tell nothing.
MOST_OPENINGS, LEAST_RAYS = 8, 24
# Surfels are indoors of whose rays no larger share is open. Of their open ones so many tell, and of
# a surfel's so many: it may lie in a crack.
MOST_OPEN, MOST_RAYS, MOST_OF_SURFEL = 0.25, 1024, 4
# Each has this share of their open rays at least. Of rays that pass it so many leave: by windows of
# ten rooms .45 to .96, by cracks under walls .05 to .3. And in the median it fills no larger share
# of what surfaces see: windows fill .01 to .07, sides of courts, and of lids of boxes, .2 and more.
LEAST_SHARE, LEAST_OPEN, MOST_SEEN = 0.04, 0.35, 0.1
# Pairs of rays whose nearest points are tried as the middle of an opening, and the shares of rays
# that are to pass close to it.
PAIRS, NEAREST = 256, (0.06, 0.12, 0.25, 0.5, 0.8)
# Planes and reaches about a place tried, in what rays pass it by, and the share of what crosses
# them there which bounds a rectangle: single rays pass elsewhere.
OFFSETS, REACHES = np.linspace(-2.0, 2.0, 17), (3.0, 6.0, 12.0, 24.0)
RIMS, FACING, LEAST_UPRIGHT = (0.025, 0.975), 0.1, 0.5
# How much further than that it reaches, of its size.
MARGIN = 0.04
# Of directions by whose cosine walls are the same, and how many are tried.
ALIKE, MOST_NORMALS = 0.999, 6


@dataclass(frozen=True, eq=False)
class Openings:
    """Rectangles through which the sky is seen.

    Attributes
    ----------
    corners : ndarray, shape (K, 3, 3)
        Corner and both edges of each, normalised frame.
    """

    corners: FloatArray

    @property
    def count(self) -> int:
        """Number of rectangles."""
        return len(self.corners)


def is_indoors(is_open: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which surfels (S,) see little of the sky, by which rays (S, N) meet nothing."""
    return np.asarray(is_open.mean(axis=1) <= MOST_OPEN)


def openings_of(
    starts: FloatArray, ways: FloatArray, normals: NDArray[np.uint32], is_open: NDArray[np.bool_]
) -> FloatArray:
    """Return corner and both edges of each opening, (K, 3, 3), none where the sky is seen widely.

    Parameters
    ----------
    starts, ways : ndarray, shape (S, N, 3)
        Of N rays of each surfel; ways are of length 1.
    normals : ndarray, shape (S, N), uint32
        At their starts, as in `Surfels`.
    is_open : ndarray, shape (S, N)
        Whether they meet nothing.
    """
    indoors = is_indoors(is_open)
    leaving = is_open & indoors[:, None] & (is_open.cumsum(axis=1) <= MOST_OF_SURFEL)
    p, w = starts[leaving].astype(np.float64), ways[leaving].astype(np.float64)
    if len(p) < LEAST_RAYS:
        return np.zeros((0, 3, 3))
    sees = leaving.any(axis=1)
    rng = np.random.default_rng(3)
    some = rng.permutation(len(p))[:MOST_RAYS]
    p, w = p[some], w[some]
    walls = _walls(unit_vectors(normals[indoors][:, 0]))
    found: list[FloatArray] = []
    left = np.arange(len(p))
    while len(found) < MOST_OPENINGS and len(left) >= LEAST_SHARE * len(p):
        middle, size = _crossing(p[left], w[left], len(p), rng)
        opening, passing = _rectangle(p[left], w[left], middle, size, walls)
        if passing.sum() < LEAST_SHARE * len(p):
            break
        through = _passes(opening, starts[sees], ways[sees])
        openness = is_open[sees][through].mean() if through.any() else 0.0
        seen = _seen_share(opening, p[left][passing], w[left][passing])
        if openness >= LEAST_OPEN and seen <= MOST_SEEN:
            found.append(opening)
        left = left[~passing]
    return np.stack(found) if found else np.zeros((0, 3, 3))


def _passes(opening: FloatArray, p: FloatArray, w: FloatArray) -> NDArray[np.bool_]:
    """Return which rays from p (..., 3) along w pass a rectangle (3, 3)."""
    corner, u, v = opening
    normal = np.cross(u, v)
    facing, to_corner = w @ normal, corner - p
    t = (to_corner @ normal) / np.where(facing == 0.0, np.inf, facing)
    d = t[..., None] * w - to_corner
    a, b = (d @ np.cross(v, normal), d @ np.cross(normal, u))
    square = normal @ normal
    return np.asarray((t > 0.0) & (a > 0.0) & (b > 0.0) & (a < square) & (b < square))


def _seen_share(opening: FloatArray, p: FloatArray, w: FloatArray) -> float:
    """Return which share of the light from all sides it can send, where rays p along w see it."""
    normal = np.cross(opening[1], opening[2])
    facing = w @ normal
    t = ((opening[0] - p) @ normal) / facing
    return float(np.median(np.abs(facing) / (np.pi * t**2)))


def _walls(normals: FloatArray) -> FloatArray:
    """Return the directions that most of `normals` have, either way."""
    left = normals
    walls: list[FloatArray] = []
    while len(left) and len(walls) < MOST_NORMALS:
        some = left[:: max(len(left) // 64, 1)]
        alike = np.abs(some @ left.T) > ALIKE
        most = int(np.argmax(alike.sum(axis=1)))
        walls.append(some[most])
        left = left[~alike[most]]
    return np.array(walls)


def _crossing(
    p: FloatArray, w: FloatArray, count: int, rng: np.random.Generator
) -> tuple[FloatArray, float]:
    """Return the place that many of some rays pass, of `count` in all, and how closely."""
    i, j = rng.integers(0, len(p), (2, PAIRS))
    between, cosine = p[j] - p[i], np.einsum("nk,nk->n", w[i], w[j])
    along_i, along_j = (np.einsum("nk,nk->n", between, w[n]) for n in (i, j))
    sine = 1.0 - cosine**2
    crosses = sine > 1e-4
    sine = np.where(crosses, sine, 1.0)
    s, t = (along_i - cosine * along_j) / sine, (cosine * along_i - along_j) / sine
    crosses &= (s > 0.0) & (t > 0.0)
    places = 0.5 * (p[i] + s[:, None] * w[i] + p[j] + t[:, None] * w[j])[crosses]
    if not len(places):
        return p[0] + w[0], 0.0
    # Squared distances of all rays from all places.
    d = places[:, None] - p
    along = np.einsum("mnk,nk->mn", d, w)
    apart = np.einsum("mnk,mnk->mn", d, d) - np.maximum(along, 0.0) ** 2
    apart.sort(axis=1)
    numbers = [int(share * count) for share in NEAREST]
    numbers = [n for n in numbers if n < len(p)] or [len(p) - 1]
    density = np.array([n / np.maximum(apart[:, n], 1e-12) for n in numbers])
    which, best = np.unravel_index(int(np.argmax(density)), density.shape)
    return places[best], float(np.sqrt(apart[best, numbers[which]]))


def _rectangle(
    p: FloatArray, w: FloatArray, middle: FloatArray, size: float, walls: FloatArray
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return the rectangle about `middle` that most rays pass for its area, and which do."""
    best, opening = -1.0, np.zeros((3, 3))
    passing = np.zeros(len(p), dtype=bool)
    for axes in _axes(walls):
        normal, sides = axes[0], axes[1:]
        facing = w @ normal
        for offset in OFFSETS:
            place = middle + offset * size * normal
            t = ((place - p) @ normal) / np.where(np.abs(facing) > FACING, facing, np.inf)
            crosses = t > 0.0
            on = sides @ (p + t[:, None] * w - place).T
            apart = (on**2).sum(axis=0)
            count = 0
            for reach in REACHES:
                close = crosses & (apart < (reach * size) ** 2)
                last, count = count, int(close.sum())
                if count == last:
                    continue
                low, high = _rims(on[:, close])
                margin = MARGIN * (high - low)
                low, high = low - margin, high + margin
                within = crosses & ((on > low[:, None]) & (on < high[:, None])).all(axis=0)
                fit = within.sum() ** 2 / max(float(np.prod(high - low)), 1e-12)
                if fit > best:
                    best, passing = fit, within
                    edges = (high - low)[:, None] * sides
                    opening = np.stack([place + low @ sides, *edges])
    return opening, passing


def _rims(on: FloatArray) -> FloatArray:
    """Return the quantiles `RIMS` of points (2, N), (2, 2), like `np.quantile`, but fast."""
    at = np.array(RIMS) * (on.shape[1] - 1)
    below = at.astype(int)
    above = np.minimum(below + 1, on.shape[1] - 1)
    ordered = np.partition(on, np.concatenate([below, above]), axis=1)
    low, high = ordered[:, below], ordered[:, above]
    return np.asarray((low + (at - below) * (high - low)).T)


def _axes(walls: FloatArray) -> Iterator[FloatArray]:
    """Yield the normal of each wall and two directions along it, as others stand on it, (3, 3)."""
    for normal in walls:
        found: list[FloatArray] = []
        for other in walls:
            u = other - normal * (other @ normal)
            if u @ u < LEAST_UPRIGHT:
                continue
            u /= np.linalg.norm(u)
            axes = np.stack([normal, u, np.cross(normal, u)])
            # Turned by quarters, rectangles are the same.
            if not any((np.abs(known[1:] @ u) > ALIKE).any() for known in found):
                found.append(axes)
        yield from found
