"""Surfels that a wall runs through: one on each side of it.

Where a wall stands on a floor, one texel of the floor may belong to two rooms. Its light
would shine from the lit one into the dark one; and what a body covers would darken what is
beside it. Lines across each surfel, a little above it, find what stands on it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, IntArray
from ssdo_gl.raytracing.bvh import Bvh
from ssdo_gl.raytracing.surface_tables import oct_words
from ssdo_gl.raytracing.surfels import LIFT, POINT_COUNT, Places, Surfels
from ssdo_gl.raytracing.triangles import SceneTriangles

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
    positions, normals, sources : ndarray
        As in `Surfels`; second parts come after all first ones.
    places : Places
    triangles : SceneTriangles
        As they were when the surfels were made.
    planes : ndarray, shape (S, 4), float32
        Points p with planes[:3] . p < planes[3] belong to the second part; 0: there is none.
    others : ndarray, shape (S,), int64
        The number of the second part; 0: there is none.
    """

    positions: NDArray[np.float32]
    normals: NDArray[np.uint32]
    sources: IntArray
    places: Places
    triangles: SceneTriangles
    planes: NDArray[np.float32]
    others: IntArray

    @property
    def count(self) -> int:
        """Number of surfels, both parts counted."""
        return len(self.positions)

    @cached_property
    def _weights(self) -> tuple[FloatArray, FloatArray]:
        """Of each point the weights of its triangle's corners, and its side: 1 front, -1 back."""
        a, b, c = np.moveaxis(self.triangles.positions.astype(np.float64)[self.sources], 2, 0)
        normal = np.cross(b - a, c - a)
        square = np.einsum("spk,spk->sp", normal, normal)
        to_point = self.positions - a
        of_c = np.einsum("spk,spk->sp", np.cross(b - a, to_point), normal) / square
        of_b = np.einsum("spk,spk->sp", np.cross(to_point, c - a), normal) / square
        height = np.einsum("spk,spk->sp", to_point, normal)
        return np.stack([1.0 - of_b - of_c, of_b, of_c], axis=-1), np.where(height < 0.0, -1.0, 1.0)

    def moved(self, triangles: SceneTriangles) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
        """Return positions and normals once the triangles, the same ones, lie elsewhere."""
        moves = np.any(triangles.positions != self.triangles.positions, axis=(1, 2))
        chosen = np.flatnonzero(moves[self.sources].any(axis=1))
        positions, normals = self.positions.copy(), self.normals.copy()
        weights, side = (array[chosen] for array in self._weights)
        corners = triangles.positions.astype(np.float64)[self.sources[chosen]]
        edges = corners[:, :, 1:] - corners[:, :, :1]
        normal = np.cross(edges[:, :, 0], edges[:, :, 1])
        normal *= (side / np.linalg.norm(normal, axis=-1))[..., None]
        at = np.einsum("spc,spck->spk", weights, corners) + LIFT * normal
        positions[chosen], normals[chosen] = at, oct_words(normal)
        return positions, normals


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
        own = surfels.sources[chosen]
        bearers = np.concatenate([own, np.repeat(own[:, :1], half, axis=1)], axis=1)
        sides.append((plane, *_filled(candidates, bearers, usable)))
    positions = np.concatenate([surfels.positions, sides[1][1].astype(np.float32)])
    positions[chosen] = sides[0][1]
    planes = np.zeros((len(positions), 4), dtype=np.float32)
    planes[chosen] = sides[0][0]
    others = np.zeros(len(positions), dtype=np.int64)
    others[chosen] = surfels.count + np.arange(len(chosen))
    normals, sources = (
        np.concatenate([array, array[chosen]]) for array in (surfels.normals, surfels.sources)
    )
    # What lies on a line lies in the plane of any triangle of the surfel.
    sources[chosen], sources[surfels.count :] = sides[0][2], sides[1][2]
    return TornSurfels(positions, normals, sources, surfels.places, bvh.triangles, planes, others)


def _face_normals(bvh: Bvh) -> FloatArray:
    corners = bvh.triangles.positions.astype(np.float64)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))


def _most_frequent(walls: IntArray) -> IntArray:
    """Return where in each row (N, L) the wall stands that most lines meet; -1: none."""
    alike = (walls[:, :, None] == walls[:, None, :]).sum(axis=2)
    return np.asarray(np.argmax(np.where(walls < 0, 0, alike), axis=1))


def _filled(
    candidates: FloatArray, sources: IntArray, usable: NDArray[np.bool_]
) -> tuple[FloatArray, IntArray]:
    """Return for each row of candidates as many as a surfel has points, usable ones in turn."""
    order = np.argsort(~usable, axis=1, kind="stable")
    count = np.maximum(usable.sum(axis=1), 1)
    turn = np.arange(POINT_COUNT) % count[:, None]
    chosen = np.take_along_axis(order, turn, axis=1)
    at = np.take_along_axis(candidates, chosen[..., None], axis=1)
    return at, np.take_along_axis(sources, chosen, axis=1)
