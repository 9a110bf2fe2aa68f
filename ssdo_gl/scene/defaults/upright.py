"""Which axis of a scan points up: its format does not say."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray, doubled_area_vectors
from ssdo_gl.scene.geometry import Mesh, SceneObject, Surfaces, corners_within

_AXES = {"y": 1, "z": 2}
# What lies within this share of the height from the bottom, and faces down, is a foot.
_FOOT_HEIGHT, _FACES_DOWN = 0.02, 0.9
# Share of the bounding box' floor by which one foot must exceed the other to tell, and how many
# times: the rim of a plate is flat, too, where its face has holes.
_CLEARLY, _MUCH_LARGER = 0.05, 2.0
# A plate that things stand on is where the coordinate is 0.
_ON_PLATE = 1e-3

# Metres from the earth's centre to its surface; how wide a tile is whose up is the same all over;
# and how high the surface is.
_EARTH_RADII, _LARGEST_TILE, _HEIGHTS = (6.35e6, 6.39e6), 1e5, 1e4


def guessed_up(meshes: Sequence[Mesh], usual: str) -> tuple[str, str]:
    """Return the axis, y or z, that points up, and what tells.

    The axis at whose low end by far the larger flat foot is, on which it does not fall over;
    or the one whose coordinate begins at 0 while the other's does not; of parts (`usual` z)
    the one that they are thin along; else `usual`, that of the format.
    """
    bounds = [mesh.bounds() for mesh in meshes]
    low, high = np.min([low for low, _ in bounds], axis=0), np.max([h for _, h in bounds], axis=0)
    middle = _middle(meshes)
    feet = {name: _foot(meshes, axis, low, high, middle) for name, axis in _AXES.items()}
    for name, other in (("y", "z"), ("z", "y")):
        if feet[name] > max(feet[other] + _CLEARLY, _MUCH_LARGER * feet[other]):
            return name, "its flat foot"
    on_plate = {
        name: abs(low[axis]) <= _ON_PLATE * (high[axis] - low[axis]) for name, axis in _AXES.items()
    }
    for name, other in (("y", "z"), ("z", "y")):
        if on_plate[name] and not on_plate[other]:
            return name, f"it stands on {name} = 0"
    extent = dict(zip("xyz", high - low, strict=True))
    thinnest = min(extent, key=lambda name: extent[name])
    if usual == "z" and thinnest != "x" and 2.5 * extent[thinnest] < np.median([*extent.values()]):
        return thinnest, "it is flat"
    return usual, "the custom of its format"


def _middle(meshes: Sequence[Mesh]) -> FloatArray:
    """Return the middle of the surface."""
    total, weighted = 0.0, np.zeros(3)
    for mesh in meshes:
        corners = mesh.positions[mesh.triangles]
        doubled = np.linalg.norm(doubled_area_vectors(corners), axis=1)
        total += float(doubled.sum())
        weighted += doubled @ corners.mean(axis=1)
    return weighted / total


def _foot(
    meshes: Sequence[Mesh], axis: int, low: FloatArray, high: FloatArray, middle: FloatArray
) -> float:
    """Return which share of the box' low side is covered by what faces it, 0 if all of it is
    to one side of the middle: a bumper of a car is no foot.
    """
    extent = high - low
    area = 0.0
    first, last = high.copy(), low.copy()
    for mesh in meshes:
        at_bottom = mesh.positions[:, axis] <= low[axis] + _FOOT_HEIGHT * extent[axis]
        corners = corners_within(mesh.positions[None], mesh.triangles, at_bottom[None])
        cross = doubled_area_vectors(corners)
        doubled = np.linalg.norm(cross, axis=1)
        faces_down = -cross[:, axis] > _FACES_DOWN * doubled
        area += 0.5 * float(doubled[faces_down].sum())
        first = np.minimum(first, corners[faces_down].min(axis=(0, 1), initial=np.inf))
        last = np.maximum(last, corners[faces_down].max(axis=(0, 1), initial=-np.inf))
    beneath = np.delete((first <= middle) & (middle <= last), axis)
    if not beneath.all():
        return 0.0
    floor = float(np.prod(np.delete(extent, axis)))
    return area / floor if floor > 0.0 else 0.0


def up_on_earth(surfaces: Surfaces) -> FloatArray | None:
    """Return the unit direction away from the earth's centre, if the origin is that centre.

    Tiles of cities are often placed so. In a map's grid a place may be as far from the origin, but
    one of its coordinates is a height.
    """
    corners = surfaces.boxes().reshape(-1, 3)
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle = 0.5 * (low + high)
    is_there = _EARTH_RADII[0] <= float(np.linalg.norm(middle)) <= _EARTH_RADII[1]
    is_tile = is_there and (high - low).max() < _LARGEST_TILE and np.abs(middle).min() > _HEIGHTS
    return math3d.normalized(middle) if is_tile else None


def turned_up(objects: Sequence[SceneObject], up: ArrayLike) -> list[SceneObject]:
    """Return objects that stand along the unit vector `up`, as ones that stand on y."""
    frame = math3d.frame_from_z(up)
    turn = np.eye(4)
    turn[:3, :3] = frame[:, [1, 2, 0]].T
    return [
        dataclasses.replace(item, world_from_object=turn @ item.world_from_object)
        for item in objects
    ]
