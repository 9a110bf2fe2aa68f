"""Points of surfels, from which their rays start, and lines across them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, IntArray
from ssdo_gl.raytracing.packed import unit_vectors
from ssdo_gl.raytracing.surfel_patches import Patches

# Points of a surfel from which its rays start: a square number, so that they are stratified.
POINTS_PER_SIDE = 4
POINT_COUNT = POINTS_PER_SIDE**2
# Rays start this far off the surface: twice `RAY_OFFSET` of shaders/rays/ray.glsl, whose
# other part, back along the ray that found the surface, is missing here.
LIFT = 8e-6
# What a ray that finds nothing has met, in place of twice its primitive and which triangle of it.
NOTHING_MET = 0xFFFFFFFF
# What is parallel to a surfel, within 8 degrees, lies on it or before it, and does not stand on it.
# Where it is closer than so much of its size, it covers it. At .1 narrow gaps between walls, which
# also are flat, are as bright as what is open: docs/far-field-experiments.md.
PARALLEL_COSINE, CLOSE = 0.99, 0.05
# Lines across a texel run this share of its width from its edges and from each other.
LINE_PLACES = (0.002, 0.33, 0.67, 0.998)


def texel_points(
    rng: np.random.Generator,
    patches: Patches,
    triangle: NDArray[np.int32],
    patch: IntArray,
    low: IntArray,
    cut: IntArray,
) -> tuple[FloatArray, FloatArray, NDArray[np.int32]]:
    """Return points, and ends of lines, of texels, (N, 16, 3), and triangles (N, 16) of the former.

    Parameters
    ----------
    triangle : ndarray, shape (P, 2)
        Both triangles of each patch.
    patch : ndarray, shape (N,)
        That each texel belongs to.
    low, cut : ndarray, shape (N, 2)
        Which texel it is along both axes, and of how many.
    """
    u = (low[:, None] + _stratified(rng, len(patch))) / cut[:, None]
    u = np.where(patches.is_joint[patch, None, None], u, _even_rings(u, low, cut))
    repeated = np.repeat(patch[:, None], POINT_COUNT, 1)
    ends = points_of(patches, repeated, (low[:, None] + _line_ends()) / cut[:, None])
    return points_of(patches, repeated, u), ends, sources_of(patches, triangle, repeated, u)


def sources_of(
    patches: Patches, triangle: NDArray[np.int32], chosen: IntArray, u: FloatArray
) -> NDArray[np.int32]:
    """Return the triangles (N, 16) that hold the places `u` of patches (N, 16)."""
    is_second = patches.is_joint[chosen] & (u[..., 0] < u[..., 1])
    return np.asarray(triangle[chosen, is_second.astype(np.int64)])


def _line_ends() -> FloatArray:
    """Return where the lines across a texel begin and end in turn, unit square, (16, 2)."""
    first, last = LINE_PLACES[0], LINE_PLACES[-1]
    rows = [[x, y] for y in LINE_PLACES for x in (first, last)]
    return np.array(rows + [[y, x] for x, y in rows])


def cosine_ways(normals: NDArray[np.uint32], turn: int = 0) -> FloatArray:
    """Return a direction from each point (S, 16) of surfels, spread by the cosine, (S, 16, 3).

    Parameters
    ----------
    normals : ndarray, shape (S, 16), uint32
        As in `Surfels`.
    turn : int
        Others each time.
    """
    # In turn, or all points that lie at one edge of a surfel would look the same way.
    order = (7 * np.arange(POINT_COUNT) + np.arange(len(normals))[:, None]) % POINT_COUNT
    u = _stratified(np.random.default_rng(2 + turn), len(normals))
    u = np.take_along_axis(u, order[..., None], axis=1)
    height, angle = 2.0 * u[..., 0] - 1.0, 2.0 * np.pi * u[..., 1]
    radius = np.sqrt(1.0 - height**2)
    sphere = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=-1)
    # A sphere that touches the surface.
    ways = unit_vectors(normals) + (1.0 - 1e-6) * sphere
    return np.asarray(ways / np.linalg.norm(ways, axis=-1, keepdims=True))


def _stratified(rng: np.random.Generator, count: int) -> FloatArray:
    """Return points (count, 16, 2) of the unit square, one in each of its cells."""
    k = np.arange(POINT_COUNT)
    corner = np.stack([k % POINTS_PER_SIDE, k // POINTS_PER_SIDE], axis=1)
    # Never on the edge, where another wall may stand.
    return np.asarray((corner + rng.uniform(0.1, 0.9, (count, POINT_COUNT, 2))) / POINTS_PER_SIDE)


def _even_rings(u: FloatArray, low: IntArray, grid: IntArray) -> FloatArray:
    """Return `u` with points of each ring around v0 spread evenly over its area."""
    count = grid[:, None, 0]
    inner = low[:, None, 0] / count
    outer = (low[:, None, 0] + 1) / count
    share = u[..., 0] * count - low[:, None, 0]
    radius = np.sqrt(inner**2 + share * (outer**2 - inner**2))
    return np.stack([radius, u[..., 1]], axis=-1)


def points_of(patches: Patches, chosen: IntArray, u: FloatArray) -> FloatArray:
    """Return the points (N, 16, 3) of patches (N, 16) at places of their grids."""
    s, t = u[..., :1], u[..., 1:]
    v0, v1, v2, v3 = (patches.corners[chosen, i] for i in range(4))
    is_first = s >= t
    first = v0 + (s - t) * (v1 - v0) + t * (v2 - v0)
    second = v0 + s * (v2 - v0) + (t - s) * (v3 - v0)
    single = v0 + s * ((1.0 - t) * (v1 - v0) + t * (v2 - v0))
    joint = np.where(is_first, first, second)
    return np.asarray(np.where(patches.is_joint[chosen][..., None], joint, single))
