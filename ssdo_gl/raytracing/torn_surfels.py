"""Surfels that a wall runs through: one on each side of it.

Where a wall stands on a floor, one texel of the floor may belong to two rooms. Its light
would shine from the lit one into the dark one; and what a body covers would darken what is
beside it. Lines across each surfel, a little above it, find what stands on it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, IntArray
from ssdo_gl.raytracing.bvh import Bvh
from ssdo_gl.raytracing.packed import oct_words
from ssdo_gl.raytracing.surfel_points import (
    LIFT,
    NOTHING_MET,
    PARALLEL_COSINE,
    POINT_COUNT,
)
from ssdo_gl.raytracing.surfels import Places, Surfels
from ssdo_gl.raytracing.triangles import SceneTriangles

# Walls meet at a corner where their normals enclose more than 45 degrees.
CORNER_COSINE = 0.7


@dataclass(frozen=True, eq=False)
class TornSurfels:
    """Surfels in two parts where something stands on them, in three where walls meet.

    Attributes
    ----------
    positions, normals, sources : ndarray
        As in `Surfels`; second parts come after all first ones, third ones at the end.
    triangles : SceneTriangles
        As they were when the surfels were made.
    planes : ndarray, shape (S, 4), float32
        Points p with planes[:3] . p < planes[3] belong to the next part; 0: there is none. Without
        a normal planes[3] is what the surfel is cut into, as `Surfels.finer`.
    others : ndarray, shape (S,), int64
        The number of the next part; 0: there is none.
    """

    positions: NDArray[np.float32]
    normals: NDArray[np.uint32]
    sources: NDArray[np.int32]
    places: Places
    triangles: SceneTriangles
    planes: NDArray[np.float32]
    others: IntArray

    @property
    def count(self) -> int:
        """Number of surfels, all parts counted."""
        return len(self.positions)

    def _weights(self, chosen: IntArray) -> tuple[FloatArray, FloatArray]:
        """Of points of N surfels the weights of corners, (N, 16, 3), and sides: 1 front, -1 back.

        They are not kept: of all surfels they took 21 MiB, for 4 ms of a frame in motion.
        """
        corners = self.triangles.positions[self.sources[chosen]].astype(np.float64)
        a, b, c = np.moveaxis(corners, 2, 0)
        normal = np.cross(b - a, c - a)
        square = np.einsum("spk,spk->sp", normal, normal)
        to_point = self.positions[chosen] - a
        of_c = np.einsum("spk,spk->sp", np.cross(b - a, to_point), normal) / square
        of_b = np.einsum("spk,spk->sp", np.cross(to_point, c - a), normal) / square
        height = np.einsum("spk,spk->sp", to_point, normal)
        return np.stack([1.0 - of_b - of_c, of_b, of_c], axis=-1), np.where(height < 0.0, -1.0, 1.0)

    def moved(self, triangles: SceneTriangles) -> TornSurfels:
        """Return the surfels once the triangles, the same ones, lie elsewhere.

        Walls that stood on them are taken to stand where they did.
        """
        if triangles is self.triangles:
            return self
        moves = np.any(triangles.positions != self.triangles.positions, axis=(1, 2))
        chosen = np.flatnonzero(moves[self.sources].any(axis=1))
        positions, normals = self.positions.copy(), self.normals.copy()
        weights, side = self._weights(chosen)
        corners = triangles.positions[self.sources[chosen]].astype(np.float64)
        edges = corners[:, :, 1:] - corners[:, :, :1]
        normal = np.cross(edges[:, :, 0], edges[:, :, 1])
        normal *= (side / np.linalg.norm(normal, axis=-1))[..., None]
        at = np.einsum("spc,spck->spk", weights, corners) + LIFT * normal
        positions[chosen], normals[chosen] = at, oct_words(normal)
        unit = triangles.half_diagonal / self.triangles.half_diagonal
        planes = self.planes.astype(np.float64)
        shift = (triangles.centre - self.triangles.centre) / self.triangles.half_diagonal
        planes[:, 3] -= planes[:, :3] @ shift
        planes[planes[:, :3].any(axis=1), 3] /= unit
        return replace(self, positions=positions, normals=normals, planes=planes.astype(np.float32))


def torn(
    surfels: Surfels, bvh: Bvh, met: IntArray, distances: FloatArray, most: int
) -> TornSurfels:
    """Return the surfels with those in parts that something stands on.

    Parameters
    ----------
    met : ndarray, shape (S, 16)
        What each line of `Surfels.lines` meets: 2 p + s for triangle s of primitive p, or
        `NOTHING_MET`; first eight lines forwards, then backwards.
    distances : ndarray, shape (S, 16)
        How far along the line, normalised frame; negative where it is met from behind.
    most : int
        Surfels in all; further ones stay in one part.
    """
    half = met.shape[1] // 2
    chosen, is_wall = _walls_on(surfels, bvh, met)
    rows = slice(max(most - surfels.count, 0))
    chosen, is_wall = chosen[rows], is_wall[rows]
    met = met[chosen]
    triangle = bvh.primitive_triangles.reshape(-1)[np.where(is_wall, met, 0)]
    face = face_normals(bvh.triangles, triangle)
    distances = np.where(is_wall, np.abs(distances[chosen]), np.inf)
    lines = _Lines(surfels, chosen, distances, face, bvh.triangles.solid[triangle])
    own = surfels.positions[chosen].astype(np.float64)
    bearers = surfels.sources[chosen]
    candidates = np.concatenate([own, lines.ends_of_parts()], axis=1)
    bearers = np.concatenate([bearers, np.repeat(bearers[:, :1], 3 * half, axis=1)], axis=1)
    is_open = np.concatenate([lines.shows(own), lines.open_parts()], axis=1)
    ways = (slice(None, half), slice(half, None))
    (plane, is_covered, is_met), (other, other_is_covered, other_is_met) = (
        _wall_that_most_meet(bvh, triangle, np.where(is_wall, met, -1), lines, way) for way in ways
    )
    height, other_height = (
        np.einsum("spk,sk->sp", candidates, wall[:, :3]) - wall[:, 3:] for wall in (plane, other)
    )
    # Between two bodies is what lies behind both walls; else the second part is what lies
    # before the second wall, and what is in between shows if both are sheets.
    is_gap = (is_covered & other_is_covered)[:, None]
    parts = [height > 0.0, np.where(is_gap, height < 0.0, other_height > 0.0)]
    corner = _Corners.of(plane, np.where(is_wall, met, -1), face, lines.met_at())
    is_between = np.any(lines.between_sheets & is_met & other_is_met, axis=1)
    corner = corner.or_else(_Corners(plane, other, is_between), corner.divides(candidates))
    room = max(most - surfels.count - len(chosen), 0)
    thirds = np.flatnonzero(corner.divides(candidates))[:room]
    for part, at_corner in zip(parts, corner.parts(candidates), strict=False):
        part[thirds] = at_corner[thirds]
    plane[thirds] = corner.through[thirds]
    sides = [_filled(candidates, bearers, part, is_open) for part in parts]
    last = corner.parts(candidates)[2][thirds]
    sides.append(_filled(candidates[thirds], bearers[thirds], last, is_open[thirds]))
    seconds, rest = surfels.count + np.arange(len(chosen)), surfels.count + len(chosen)
    numbers = (chosen, seconds, rest + np.arange(len(thirds)))
    # What lies on a line lies in the plane of any triangle of the surfel.
    repeated = np.concatenate([np.arange(surfels.count), chosen, chosen[thirds]])
    positions, sources = surfels.positions[repeated], surfels.sources[repeated]
    for number, (at, bearer) in zip(numbers, sides, strict=True):
        positions[number], sources[number] = at, bearer
    planes = np.zeros((len(positions), 4), dtype=np.float32)
    planes[: surfels.count, 3] = surfels.finer
    planes[chosen], planes[seconds[thirds]] = plane, corner.ending[thirds]
    others = np.zeros(len(positions), dtype=np.int64)
    others[chosen], others[seconds[thirds]] = numbers[1:]
    normals, places = surfels.normals[repeated], surfels.places
    return TornSurfels(positions, normals, sources, places, bvh.triangles, planes, others)


@dataclass(frozen=True, eq=False)
class _Corners:
    """Two walls that part each of N surfels in three: one ends at the other, or both at a corner.

    Two sheets side by side are such walls, too.

    Attributes
    ----------
    through, ending : ndarray, shape (N, 4)
        Planes n . p = d; the second wall ends at the first, and stands behind it.
    is_there : ndarray, shape (N,), bool
        Whether there are two.
    """

    through: FloatArray
    ending: FloatArray
    is_there: NDArray[np.bool_]

    @classmethod
    def of(cls, plane: FloatArray, met: IntArray, face: FloatArray, at: FloatArray) -> _Corners:
        """Return the walls: one of each surfel is known by its plane (N, 4).

        Parameters
        ----------
        met, face, at : ndarray
            What each line meets, -1: nothing, with unit normals (N, 16, 3), and where.
        """
        across = np.abs(np.einsum("slk,sk->sl", face, plane[:, :3]))
        is_other = (met >= 0) & (across < CORNER_COSINE)
        line = (np.arange(len(met)), _most_frequent(np.where(is_other, met, -1)))
        other = np.concatenate(
            [face[line], np.einsum("sk,sk->s", face[line], at[line])[:, None]], 1
        )
        is_first = (met >= 0) & (across > PARALLEL_COSINE)
        before, behind = _sides(plane, at, is_other)
        # A wall on both sides of which the other stands runs through; the other ends there.
        swaps = before & behind
        through = np.where(swaps[:, None], other, plane)
        ending = np.where(swaps[:, None], plane, other)
        before, _ = _sides(through, at, np.where(swaps[:, None], is_first, is_other))
        return cls(np.where(before[:, None], -through, through), ending, is_other.any(axis=1))

    def or_else(self, other: _Corners, chosen: NDArray[np.bool_]) -> _Corners:
        """Return the chosen ones (N,) of these walls, and `other` for the rest."""
        rows = chosen[:, None]
        return _Corners(
            np.where(rows, self.through, other.through),
            np.where(rows, self.ending, other.ending),
            np.where(chosen, self.is_there, other.is_there),
        )

    def parts(self, points: FloatArray) -> tuple[NDArray[np.bool_], ...]:
        """Return which points (N, P, 3) lie before the first wall, and on either side behind it."""
        first, second = (
            np.einsum("spk,sk->sp", points, wall[:, :3]) - wall[:, 3:]
            for wall in (self.through, self.ending)
        )
        return first > 0.0, (first < 0.0) & (second > 0.0), (first < 0.0) & (second < 0.0)

    def divides(self, points: FloatArray) -> NDArray[np.bool_]:
        """Return for which surfels (N,) there are two walls, and points in all three parts."""
        filled = [part.any(axis=1) for part in self.parts(points)]
        return np.asarray(self.is_there & np.all(filled, axis=0))


def _wall_that_most_meet(
    bvh: Bvh, triangle: NDArray[np.int32], met: IntArray, lines: _Lines, way: slice
) -> tuple[FloatArray, NDArray[np.bool_], NDArray[np.bool_]]:
    """Return the wall that most lines of each surfel meet one way, `met` being -1 where none is.

    Its plane (N, 4) has in front what the lines come from; further whether they come from
    inside a body (N,), and which of them (N, 8) meet that triangle.
    """
    line = (np.arange(len(met)), _most_frequent(met[:, way]))
    wall = triangle[:, way][line]
    normal = face_normals(bvh.triangles, wall)
    away = np.einsum("sk,sk->s", normal, lines.along[:, way][line]) > 0.0
    normal = np.where(away[:, None], -normal, normal)
    reach = np.einsum("sk,sk->s", normal, bvh.triangles.positions[wall, 0].astype(np.float64))
    plane = np.concatenate([normal, reach[:, None]], axis=1)
    return plane, lines.from_behind[:, way][line], triangle[:, way] == wall[:, None]


def _sides(
    plane: FloatArray, at: FloatArray, chosen: NDArray[np.bool_]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return whether any of the chosen points (N, L, 3) lie before and behind a plane (N, 4)."""
    height = np.einsum("slk,sk->sl", at, plane[:, :3]) - plane[:, 3:]
    return (chosen & (height > LIFT)).any(axis=1), (chosen & (height < -LIFT)).any(axis=1)


class _Lines:
    """Eight lines across each of N surfels: how far each is free from both of its ends.

    Two halves, forwards and backwards, as in `torn`; `distances` are infinite where nothing
    is met, `face` and `is_solid` are of what is met. A line that meets a body from behind began
    inside of it; sheets have no inside.
    """

    def __init__(
        self,
        surfels: Surfels,
        chosen: IntArray,
        distances: FloatArray,
        face: FloatArray,
        is_solid: NDArray[np.bool_],
    ) -> None:
        self.starts, self.along, length = surfels.lines(chosen)
        self.half = half = distances.shape[1] // 2
        self.length = length[:, :half]
        self.free = free = np.minimum(distances, length)
        # Along the forward line: up to where, and from where, nothing stands.
        self.leaves, self.returns = free[:, :half], self.length - free[:, half:]
        is_wall = np.isfinite(distances)
        self.is_free = ~is_wall[:, :half]
        facing_away = np.einsum("slk,slk->sl", face, self.along) > 0.0
        self.from_behind = is_wall & is_solid & facing_away
        self.first, self.last = self.from_behind[:, :half], self.from_behind[:, half:]
        # Both ways meet one and the same sheet at one place, but for rounding.
        apart = self.returns - self.leaves > LIFT
        is_sheet = is_wall & ~is_solid
        self.between_sheets = is_sheet[:, :half] & is_sheet[:, half:] & apart
        self.between = self.first & self.last | self.between_sheets

    def met_at(self) -> FloatArray:
        """Return where each line ends, forwards and backwards, (N, 16, 3)."""
        return self.starts + self.free[..., None] * self.along

    def ends_of_parts(self) -> FloatArray:
        """Return the middle of what is free at the start, at the end and in between, (N, 24, 3)."""
        middles = (self.leaves, self.returns + self.length, self.leaves + self.returns)
        first, along = self.starts[:, : self.half], self.along[:, : self.half]
        return np.concatenate([first + 0.5 * t[..., None] * along for t in middles], axis=1)

    def open_parts(self) -> NDArray[np.bool_]:
        """Return which of `ends_of_parts` show, (N, 24)."""
        between = self.between & (self.returns > self.leaves)
        met = ~self.is_free
        return np.concatenate([met & ~self.first, met & ~self.last, between], axis=1)

    def shows(self, points: FloatArray) -> NDArray[np.bool_]:
        """Return which points (N, 16, 3) are not covered, by the nearest line either way."""
        to_point = points[:, :, None] - self.starts[:, None, : self.half]
        at = np.einsum("splk,slk->spl", to_point, self.along[:, : self.half])
        off = np.einsum("splk,splk->spl", to_point, to_point) - at**2
        is_open = np.where(
            at < self.leaves[:, None],
            ~self.first[:, None],
            np.where(at > self.returns[:, None], ~self.last[:, None], self.between[:, None]),
        )
        is_open |= self.is_free[:, None]
        quarter = self.half // 2
        ways = [
            np.take_along_axis(is_open[..., way], np.argmin(off[..., way], axis=2)[..., None], 2)
            for way in (slice(None, quarter), slice(quarter, None))
        ]
        return np.asarray((ways[0] | ways[1])[..., 0])


def _walls_on(surfels: Surfels, bvh: Bvh, met: IntArray) -> tuple[IntArray, NDArray[np.bool_]]:
    """Return the surfels (N,) that something stands on, and which lines (N, 16) meet it."""
    is_wall = met != NOTHING_MET
    # Most surfels have nothing on them.
    chosen = _torn_rows(is_wall)
    is_wall = is_wall[chosen]
    triangle = bvh.primitive_triangles.reshape(-1)[np.where(is_wall, met[chosen], 0)]
    face = face_normals(bvh.triangles, triangle)
    is_wall &= np.abs(np.einsum("slk,sk->sl", face, surfels.looks[chosen])) < PARALLEL_COSINE
    rows = _torn_rows(is_wall)
    return chosen[rows], is_wall[rows]


def _torn_rows(is_wall: NDArray[np.bool_]) -> IntArray:
    """Return the rows (N, 16) with a line that meets a wall either way."""
    half = is_wall.shape[1] // 2
    return np.flatnonzero(is_wall[:, :half].any(axis=1) & is_wall[:, half:].any(axis=1))


def face_normals(triangles: SceneTriangles, chosen: NDArray[np.int32]) -> FloatArray:
    """Return unit normals (..., 3) of some triangles (...)."""
    a, b, c = np.moveaxis(triangles.positions[chosen].astype(np.float64), -2, 0)
    normals = np.cross(b - a, c - a)
    return np.asarray(normals / np.linalg.norm(normals, axis=-1, keepdims=True))


def _most_frequent(walls: IntArray) -> IntArray:
    """Return where in each row (N, L) the wall stands that most lines meet; -1: none."""
    alike = (walls[:, :, None] == walls[:, None, :]).sum(axis=2)
    return np.asarray(np.argmax(np.where(walls < 0, 0, alike), axis=1))


def _filled(
    candidates: FloatArray,
    sources: NDArray[np.int32],
    belongs: NDArray[np.bool_],
    is_open: NDArray[np.bool_],
) -> tuple[FloatArray, NDArray[np.int32]]:
    """Return for each row of candidates as many as a surfel has points, the best in turn.

    The best are those that belong to the part and are not covered; if there is none, those
    that belong to it.
    """
    rank = np.where(belongs, np.where(is_open, 0, 1), 2)
    order = np.argsort(rank, axis=1, kind="stable")
    count = (rank == rank.min(axis=1, keepdims=True)).sum(axis=1)
    turn = np.arange(POINT_COUNT) % count[:, None]
    chosen = np.take_along_axis(order, turn, axis=1)
    at = np.take_along_axis(candidates, chosen[..., None], axis=1)
    return at, np.take_along_axis(sources, chosen, axis=1)
