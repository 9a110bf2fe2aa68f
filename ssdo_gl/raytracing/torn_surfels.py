"""Surfels that a wall runs through: one on each side of it.

Where a wall stands on a floor, one texel of the floor may belong to two rooms. Its light
would shine from the lit one into the dark one; and what a body covers would darken what is
beside it. Lines across each surfel, a little above it, find what stands on it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, IntArray
from ssdo_gl.raytracing.bvh import Bvh
from ssdo_gl.raytracing.surfels import POINT_COUNT, Surfels

# What a line meets that is parallel to the surfel, within 8 degrees, does not stand on it.
PARALLEL_COSINE = 0.99
# Of a line's free part, where rays start if no point of the surfel lies on its side.
FREE_SHARE = 0.5
NOTHING_MET = 0xFFFFFFFF


@dataclass(frozen=True, eq=False)
class TornSurfels:
    """Surfels in two parts where something stands on them.

    Attributes
    ----------
    positions, normals : ndarray
        As in `Surfels`; second parts come after all first ones.
    planes : ndarray, shape (S, 4), float32
        Points p with planes[:3] . p < planes[3] belong to the second part; 0: there is none.
    others : ndarray, shape (S,), int64
        The number of the second part; 0: there is none.
    """

    positions: NDArray[np.float32]
    normals: NDArray[np.uint32]
    planes: NDArray[np.float32]
    others: IntArray

    @property
    def count(self) -> int:
        """Number of surfels, both parts counted."""
        return len(self.positions)


def torn(
    surfels: Surfels,
    bvh: Bvh,
    met: IntArray,
    distances: FloatArray,
    most: int,
) -> TornSurfels:
    """Return the surfels with those in two parts that something stands on.

    Parameters
    ----------
    surfels : Surfels
    bvh : Bvh
    met : ndarray, shape (S, 16)
        What each line of `Surfels.lines` meets: 2 p + s for triangle s of primitive p, or
        `NOTHING_MET`; first eight lines forwards, then backwards.
    distances : ndarray, shape (S, 16)
        How far along the line, normalised frame.
    most : int
        Surfels in all; further ones stay in one part.
    """
    triangle = bvh.primitive_triangles.reshape(-1)[np.where(met == NOTHING_MET, 0, met)]
    is_wall = met != NOTHING_MET
    facing = np.abs(np.einsum("slk,sk->sl", _face_normals(bvh)[triangle], surfels.looks))
    is_wall &= facing < PARALLEL_COSINE
    half = met.shape[1] // 2
    chosen = np.flatnonzero(is_wall[:, :half].any(axis=1) & is_wall[:, half:].any(axis=1))
    chosen = chosen[: max(most - surfels.count, 0)]
    starts, along = surfels.lines(chosen)
    free = starts + (FREE_SHARE * distances[chosen])[..., None] * along
    sides = []
    for part in (slice(None, half), slice(half, None)):
        walls = is_wall[chosen, part]
        line = (np.arange(len(chosen)), _most_frequent(np.where(walls, met[chosen, part], -1)))
        wall = triangle[chosen, part][line]
        normal = _face_normals(bvh)[wall]
        # In front of the wall is where the line came from.
        away = np.einsum("sk,sk->s", normal, along[:, part][line]) > 0.0
        normal = np.where(away[:, None], -normal, normal)
        reach = np.einsum("sk,sk->s", normal, bvh.triangles.positions[wall, 0].astype(np.float64))
        candidates = np.concatenate([surfels.positions[chosen], free[:, part]], axis=1)
        usable = np.concatenate([np.ones((len(chosen), POINT_COUNT), dtype=bool), walls], axis=1)
        usable &= np.einsum("spk,sk->sp", candidates, normal) > reach[:, None]
        plane = np.concatenate([normal, reach[:, None]], axis=1)
        sides.append((plane, _filled(candidates, usable)))
    positions = np.concatenate([surfels.positions, sides[1][1].astype(np.float32)])
    positions[chosen] = sides[0][1]
    planes = np.zeros((len(positions), 4), dtype=np.float32)
    planes[chosen] = sides[0][0]
    others = np.zeros(len(positions), dtype=np.int64)
    others[chosen] = surfels.count + np.arange(len(chosen))
    normals = np.concatenate([surfels.normals, surfels.normals[chosen]])
    return TornSurfels(positions, normals, planes, others)


def _face_normals(bvh: Bvh) -> FloatArray:
    corners = bvh.triangles.positions.astype(np.float64)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))


def _most_frequent(walls: IntArray) -> IntArray:
    """Return where in each row (N, L) the wall stands that most lines meet; -1: none."""
    alike = (walls[:, :, None] == walls[:, None, :]).sum(axis=2)
    return np.asarray(np.argmax(np.where(walls < 0, 0, alike), axis=1))


def _filled(candidates: FloatArray, usable: NDArray[np.bool_]) -> FloatArray:
    """Return for each row (N, C, 3) as many points as a surfel has, usable ones in turn."""
    order = np.argsort(~usable, axis=1, kind="stable")
    count = np.maximum(usable.sum(axis=1), 1)
    turn = np.arange(POINT_COUNT) % count[:, None]
    chosen = np.take_along_axis(order, turn, axis=1)
    return np.take_along_axis(candidates, chosen[..., None], axis=1)
