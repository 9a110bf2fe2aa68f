"""What a scene is of, without stray bits far from it and without what it merely stands in.

Viewers that frame the box of everything show a room as a dot because of one forgotten
quad. Nothing is hidden here: cameras and lengths that nobody gave go by the main part.
"""

from __future__ import annotations

import weakref
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, lengths_of_rows, spread_directions
from ssdo_gl.scene.geometry.mesh import Mesh
from ssdo_gl.scene.geometry.surfaces import Surfaces
from ssdo_gl.scene.geometry.topology import placed

# Something empty that is wider than this share of what is looked at parts it.
_GAP = 0.2
# Strays are farther from the main part than it is large, and have no more than this share
# of the area of all.
_STRAY_DISTANCE, _STRAY_AREA = 1.0, 0.01
# Where all is more than this many times as large as the main part, that would be less than a pixel.
_SPECK_RATIO = 1000.0
# What the main part stands on or in is this many times as large, in at most so many pieces;
# the main part has the triangles of a box at least.
_BACKDROP_RATIO, _MAX_BACKDROPS, _FEWEST_TRIANGLES = 6.0, 8, 12
# A ground is this flat; a dome hides this share of the directions above the horizon.
_FLATNESS, _DOME_SHARE = 0.01, 0.8
_DIRECTIONS, _MAX_DOME_TRIANGLES = 64, 1 << 16
# More are looked at as a whole: 100 000 take 0.16 s.
_MAX_PIECES = 1 << 17


@dataclass(frozen=True)
class _Pieces:
    """Parts of meshes between which there is nothing, as boxes.

    Attributes
    ----------
    low, high : ndarray, shape (N, 3)
    area : ndarray, shape (N,)
    count : ndarray, shape (N,)
        Of their triangles.
    owner, copy : ndarray, shape (N,)
        Index of the object, and of its instance.
    """

    low: FloatArray
    high: FloatArray
    area: FloatArray
    count: NDArray[np.int64]
    owner: NDArray[np.int64]
    copy: NDArray[np.int64]

    def box(self, chosen: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
        return self.low[chosen].min(axis=0), self.high[chosen].max(axis=0)


@dataclass(frozen=True)
class MainPart:
    """Bounds of the main part, and what they leave out.

    Attributes
    ----------
    low, high : ndarray, shape (3,)
        World space.
    stray_count : int
        Triangles of small things far away, and of those so far that nothing would be seen.
    stands_on, stands_in : bool
        Whether a far larger ground, or a dome, is left out.
    """

    low: FloatArray
    high: FloatArray
    stray_count: int = 0
    stands_on: bool = False
    stands_in: bool = False

    @property
    def is_all(self) -> bool:
        """Whether nothing is left out."""
        return not (self.stray_count or self.stands_on or self.stands_in)

    @property
    def note(self) -> str:
        """What is left out, in one line; empty if nothing is."""
        left_out = [
            f"{self.stray_count} stray triangles far from the rest" if self.stray_count else "",
            "the ground, far larger than what is on it" if self.stands_on else "",
            "the dome around it" if self.stands_in else "",
        ]
        named = " and ".join(text for text in left_out if text)
        return f"camera and radius go by the main part, without {named}" if named else ""


def main_part(surfaces: Surfaces) -> MainPart:
    """Return the part of a scene that its default camera is to show.

    The box of everything, unless little of the scene is far from the rest of it, or the
    rest stands on a flat ground or in a dome that is far larger.
    """
    boxes = surfaces.boxes().reshape(-1, 3)
    everything = MainPart(boxes.min(axis=0), boxes.max(axis=0))
    if len(boxes) > 8 * _MAX_PIECES:
        return everything
    pieces = _pieces(surfaces)
    # No more than the range of lengths: those of 1e300 have no square.
    if len(pieces.area) < 2 or not np.isfinite(pieces.area.sum()) or not pieces.area.sum() > 0.0:
        return everything
    extents = lengths_of_rows(pieces.high - pieces.low)
    largest = np.argsort(-extents, kind="stable")
    found = everything
    for count in range(min(_MAX_BACKDROPS, len(largest) - 1) + 1):
        if count and extents[largest[count - 1]] < _BACKDROP_RATIO * extents[largest[count]]:
            continue
        is_backdrop = np.zeros(len(largest), dtype=bool)
        is_backdrop[largest[:count]] = True
        is_main = _without_strays(pieces, ~is_backdrop)
        low, high = pieces.box(is_main)
        if count:
            if extents[largest[count - 1]] < _BACKDROP_RATIO * float(np.linalg.norm(high - low)):
                continue
            if pieces.count[is_main].sum() < _FEWEST_TRIANGLES:
                break
        is_under = is_backdrop & _is_under(pieces, low, high)
        in_dome = bool((is_backdrop & ~is_under).any())
        # Lamps set flush into a ceiling, say, are no more than a part of their room.
        if in_dome and (high - low).min() <= _FLATNESS * (high - low).max():
            continue
        if in_dome and not _is_dome(surfaces, pieces, is_backdrop, 0.5 * (low + high)):
            continue
        strays = int(pieces.count[~is_main & ~is_backdrop].sum())
        if count or strays:
            found = MainPart(low, high, strays, bool(is_under.any()) and not in_dome, in_dome)
    return found


def _pieces(surfaces: Surfaces) -> _Pieces:
    parts: list[tuple[FloatArray, ...]] = []
    for index, item in enumerate(surfaces.objects):
        low, high, area, count = _pieces_of(surfaces.mesh(item))
        corners = np.stack([np.where([i & 1, i & 2, i & 4], high, low) for i in range(8)])
        points = placed(corners, item.world_from_object)
        scale = np.abs(np.linalg.det(item.world_from_object[:, :3, :3])) ** (2.0 / 3.0)
        copies, pieces = len(points), len(area)
        parts.append(
            (
                points.min(axis=1).reshape(-1, 3),
                points.max(axis=1).reshape(-1, 3),
                (scale[:, None] * area).reshape(-1),
                np.tile(count, copies),
                np.full(copies * pieces, index),
                np.repeat(np.arange(copies), pieces),
            )
        )
    return _Pieces(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


_known: weakref.WeakKeyDictionary[Mesh, tuple[FloatArray, ...]] = weakref.WeakKeyDictionary()


def _pieces_of(mesh: Mesh) -> tuple[FloatArray, ...]:
    """Return corners (P, 3) of the boxes of a mesh's pieces, areas (P,), triangle counts (P,)."""
    if mesh not in _known:
        _known[mesh] = _made_pieces(mesh)
    return _known[mesh]


def _made_pieces(mesh: Mesh) -> tuple[FloatArray, ...]:
    corners = [mesh.positions[mesh.triangles[:, corner]] for corner in range(3)]
    low, high = np.minimum.reduce(corners), np.maximum.reduce(corners)
    area = 0.5 * lengths_of_rows(np.cross(corners[1] - corners[0], corners[2] - corners[0]))
    made = []
    waiting = [np.arange(len(area))]
    while waiting:
        chosen = waiting.pop()
        split = _split(low[chosen], high[chosen])
        if split is None:
            bounds = low[chosen].min(axis=0), high[chosen].max(axis=0)
            made.append((*bounds, area[chosen].sum(), len(chosen)))
        else:
            waiting += [chosen[~split], chosen[split]]
    lows, highs, areas, counts = zip(*made, strict=True)
    return np.array(lows), np.array(highs), np.array(areas), np.array(counts)


def _split(low: FloatArray, high: FloatArray) -> NDArray[np.bool_] | None:
    """Return which boxes (N, 3) lie beyond the widest gap between them; None if it is narrow."""
    best, beyond = _GAP, None
    for axis in range(3):
        extent = high[:, axis].max() - low[:, axis].min()
        if len(low) < 2 or not extent > 0.0:
            continue
        order = np.argsort(low[:, axis], kind="stable")
        starts = low[order[1:], axis]
        gaps = starts - np.maximum.accumulate(high[order, axis])[:-1]
        widest = int(np.argmax(gaps))
        if gaps[widest] > best * extent:
            best, beyond = float(gaps[widest] / extent), low[:, axis] >= starts[widest]
    return beyond


def _without_strays(pieces: _Pieces, chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return those of the chosen pieces that are not far from most of their area."""
    seed = np.flatnonzero(chosen)
    while (split := _split(pieces.low[seed], pieces.high[seed])) is not None:
        areas = [float(pieces.area[seed[side]].sum()) for side in (~split, split)]
        seed = seed[split if areas[1] > areas[0] else ~split]
    is_main = np.zeros(len(chosen), dtype=bool)
    is_main[seed] = True
    while True:
        low, high = pieces.box(is_main)
        apart = np.maximum(np.maximum(pieces.low - high, low - pieces.high), 0.0)
        near = lengths_of_rows(apart) <= _STRAY_DISTANCE * float(np.linalg.norm(high - low))
        grown = is_main | (chosen & near)
        if (grown == is_main).all():
            break
        is_main = grown
    left_out = pieces.area[chosen & ~is_main].sum()
    of_main, of_all = (float(np.ptp(pieces.box(part), axis=0).max()) for part in (is_main, chosen))
    is_speck = of_all > _SPECK_RATIO * of_main
    return is_main if is_speck or left_out <= _STRAY_AREA * pieces.area[chosen].sum() else chosen


def _is_under(pieces: _Pieces, low: FloatArray, high: FloatArray) -> NDArray[np.bool_]:
    """Return which pieces are flat, level and just below the middle of a box."""
    extent = pieces.high - pieces.low
    is_flat = extent[:, 1] <= _FLATNESS * np.minimum(extent[:, 0], extent[:, 2])
    below = 0.5 * (low[1] + high[1]) - pieces.low[:, 1]
    return np.asarray(is_flat & (below >= 0.0) & (below <= float(np.linalg.norm(high - low))))


def _is_dome(
    surfaces: Surfaces, pieces: _Pieces, is_backdrop: NDArray[np.bool_], middle: FloatArray
) -> bool:
    """Return whether the insides of what the pieces are of hide the sky from `middle`."""
    found = sorted(
        {(int(pieces.owner[i]), int(pieces.copy[i])) for i in np.flatnonzero(is_backdrop)}
    )
    if (
        sum(len(surfaces.mesh(surfaces.objects[owner]).triangles) for owner, _ in found)
        > _MAX_DOME_TRIANGLES
    ):
        return False
    shells = [(surfaces.mesh(surfaces.objects[owner]), owner, copy) for owner, copy in found]
    corners = np.concatenate(
        [placed(m.corners(), surfaces.objects[o].world_from_object[[c]])[0] for m, o, c in shells]
    )
    directions = spread_directions(_DIRECTIONS, lowest=0.0)
    return float(np.mean([_is_hidden(corners - middle, d) for d in directions])) >= _DOME_SHARE


def _is_hidden(corners: FloatArray, direction: FloatArray) -> bool:
    """Return whether a ray from the origin meets the front of one of the triangles (T, 3, 3)."""
    a, b, c = np.moveaxis(corners, 1, 0)
    # Volumes that the ray spans with the edges: negative where it passes inside, seen from the
    # front. A body that has something small within shows its back.
    sides = np.stack([np.cross(p, q) @ direction for p, q in ((a, b), (b, c), (c, a))])
    meets = (sides <= 0.0).all(axis=0) & (np.cross(b - a, c - a) @ direction < 0.0)
    return bool((meets & (np.einsum("ij,ij->i", np.cross(b - a, c - a), a) < 0.0)).any())
