"""Points of surfels that something flat covers: a rug, a picture, the pane of a window.

Rays that meet a surfel seldom meet it there, and the light that is missing there must not be
missing beside it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, IntArray
from ssdo_gl.raytracing.bvh import Bvh
from ssdo_gl.raytracing.packed import unit_vectors
from ssdo_gl.raytracing.surfel_points import CLOSE, NOTHING_MET, PARALLEL_COSINE, POINT_COUNT
from ssdo_gl.raytracing.torn_surfels import TornSurfels, face_normals


def outward(surfels: TornSurfels) -> tuple[FloatArray, FloatArray]:
    """Return the way out from each point, (S, 16, 3), and how far what covers it lies there."""
    reach = CLOSE * np.linalg.norm(np.ptp(surfels.positions, axis=1), axis=1)
    return unit_vectors(surfels.normals), np.tile(reach[:, None], POINT_COUNT)


def covered(bvh: Bvh, met: IntArray, ways: FloatArray) -> NDArray[np.bool_]:
    """Return which rays along `ways` (S, N, 3) meet what lies across them, as `met` (S, N) says."""
    found = np.zeros(met.shape, dtype=bool)
    rows = met != NOTHING_MET
    face = face_normals(bvh.triangles, bvh.primitive_triangles.reshape(-1)[met[rows]])
    found[rows] = np.abs(np.einsum("nk,nk->n", face, ways[rows])) > PARALLEL_COSINE
    return found


def uncovered(surfels: TornSurfels, is_covered: NDArray[np.bool_]) -> TornSurfels:
    """Return the surfels with open points in place of covered ones, (S, 16)."""
    chosen = np.flatnonzero(is_covered.any(axis=1) & ~is_covered.all(axis=1))
    open_first = np.argsort(is_covered[chosen], axis=1, kind="stable")
    count = POINT_COUNT - is_covered[chosen].sum(axis=1)
    in_turn = np.arange(POINT_COUNT) % count[:, None]
    kept = np.tile(np.arange(POINT_COUNT), (surfels.count, 1))
    kept[chosen[:, None], open_first] = np.take_along_axis(open_first, in_turn, axis=1)
    return replace(
        surfels,
        positions=np.take_along_axis(surfels.positions, kept[..., None], axis=1),
        normals=np.take_along_axis(surfels.normals, kept, axis=1),
        sources=np.take_along_axis(surfels.sources, kept, axis=1),
    )
