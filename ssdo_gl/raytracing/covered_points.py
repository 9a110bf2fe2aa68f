"""Points of surfels that are hidden: by something flat as a rug, or within another body.

Rays that meet a surfel seldom meet it there, and the light that is missing there must not be
missing beside it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, IntArray
from ssdo_gl.raytracing.bvh import Bvh
from ssdo_gl.raytracing.packed import unit_vectors
from ssdo_gl.raytracing.surfel_points import (
    CLOSE,
    NOTHING_MET,
    PARALLEL_COSINE,
    POINT_COUNT,
    cosine_ways,
)
from ssdo_gl.raytracing.torn_surfels import TornSurfels, face_normals

# Of a point so many rays must all meet backs. With six, or a reach of two widths, rooms come out
# the same to .1 %: docs/far-field-experiments.md.
ENCLOSING_RAYS = 4
Trace = Callable[[NDArray[Any], FloatArray, FloatArray], tuple[IntArray, FloatArray]]


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


def enclosed(surfels: TornSurfels, trace: Trace) -> NDArray[np.bool_]:
    """Return which points (S, 16) lie within another body, as the foot of a post in the floor.

    Rays from there meet backs of faces alone, no farther away than the surfel is wide. Asked of
    fronts only: from the insides of bodies, and of rooms that are boxes, backs are all that is met.

    Parameters
    ----------
    trace : callable
        Returns what rays from starts (S, 16, 3) along ways (S, 16, 3) meet, both (S, 16), and how
        far away, negative from behind; they go as far as (S, 16), and not at all where negative.
    """
    width = np.linalg.norm(np.ptp(surfels.positions, axis=1), axis=1)[:, None]
    face = face_normals(surfels.triangles, surfels.sources)
    found = np.einsum("spk,spk->sp", unit_vectors(surfels.normals), face) > 0.0
    for turn in range(ENCLOSING_RAYS):
        ways = cosine_ways(surfels.normals, turn)
        _, away = trace(surfels.positions, ways, np.where(found, width, -1.0))
        found &= away < 0.0
    return np.asarray(found)


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
