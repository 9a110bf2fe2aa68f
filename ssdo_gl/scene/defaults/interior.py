"""A place to stand and a light for a closed room, of which the outside shows nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray, lengths_of_rows
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry import MainPart, Mesh, SceneObject, main_part, placed
from ssdo_gl.scene.lights import RectangleLight

# What photographers of rooms use: 24 mm before 24 mm by 36 mm, 53 degrees high.
ROOM_FOV_DEGREES = 53.0
# Where one may stand: in the corners and before the middles of the walls, this share of the
# room from them, at this height; level, so that upright edges stay upright.
_INSET, _EYE_HEIGHT = 0.12, 0.55
# Things in the room count as much as twice the distance; not what is this near, of the diagonal.
_CONTENT_WEIGHT, _TOO_NEAR = 0.7, 0.1
# Of more triangles the larger ones hide the view.
_MAX_TRIANGLES = 1 << 15
_COLUMNS, _ROWS = 13, 7
# A room has something in it: a table, say.
_FEWEST_TRIANGLES = 12
# A room is hidden where half of what is seen from outside is a wall within this share of the
# way through it; it is full where so many of its triangles are not of the walls.
_NEAR_WALL, _FULL = 0.25, 0.9
# Walls in so many of these directions keep light out.
_DIRECTIONS, _SURROUNDED = 128, 0.9
# Of more copies of triangles than these none is looked at.
_MOST_TRIANGLES = 1 << 22
# The light's side, its gap below the ceiling, and what it sends to the floor.
_PANEL_SHARE, _PANEL_GAP, _FLOOR_IRRADIANCE = 0.3, 0.02, 1.5
_PANEL_COLOR = np.array([1.03, 1.0, 0.95])


@dataclass(frozen=True)
class Interior:
    """A closed room.

    Attributes
    ----------
    low, high : ndarray, shape (3,)
        World space.
    corners : ndarray, shape (T, 3, 3)
        Of the triangles that hide most.
    is_content : ndarray, shape (T,)
        Whether they are not of the walls.
    content_share : float
        Of all triangles.
    """

    low: FloatArray
    high: FloatArray
    corners: FloatArray
    is_content: NDArray[np.bool_]
    content_share: float

    def camera(self, fov_y: float, exposure: float) -> Camera:
        """Return the camera near the walls, level, that sees far and most of what is there."""
        extent, middle = self.high - self.low, 0.5 * (self.low + self.high)
        best, chosen = -np.inf, None
        for x in (-1.0, 0.0, 1.0):
            for z in (1.0, 0.0, -1.0):
                if x == z == 0.0:
                    continue
                position = middle + (0.5 - _INSET) * extent * [x, 0.0, z]
                position[1] = self.low[1] + _EYE_HEIGHT * extent[1]
                target = middle * [1.0, 0.0, 1.0] + position * [0.0, 1.0, 0.0]
                camera = Camera(
                    math3d.vector(position),
                    math3d.vector(target),
                    fov_y=max(fov_y, ROOM_FOV_DEGREES),
                    exposure=exposure,
                )
                distance, shows = self._seen(position, _rays(camera))
                far = np.clip(distance / self._diagonal, 1e-3, 1.0)
                # Of distances the logarithm: what is close hides much.
                seen = np.log(far) + _CONTENT_WEIGHT * (shows & (far > _TOO_NEAR))
                if seen.mean() > best:
                    best, chosen = float(seen.mean()), camera
        assert chosen is not None
        return chosen

    def surrounds(self, place: FloatArray) -> bool:
        """Return whether one sees walls in nearly all directions from a place (3,)."""
        up = (np.arange(_DIRECTIONS) + 0.5) * (2.0 / _DIRECTIONS) - 1.0
        turn = np.pi * (1.0 + 5.0**0.5) * np.arange(_DIRECTIONS)
        flat = np.sqrt(1.0 - up**2)
        around = np.stack([flat * np.cos(turn), up, flat * np.sin(turn)], axis=1)
        return float(np.isfinite(self._seen(place, around)[0]).mean()) >= _SURROUNDED

    def hides_from(self, camera: Camera) -> bool:
        """Return whether there is much in it, which a camera outside does not see for walls."""
        rays, place = _rays(camera), np.asarray(camera.position)
        with np.errstate(divide="ignore", invalid="ignore"):
            ends = [(corner - place) / rays for corner in (self.low, self.high)]
        enters, leaves = np.minimum(*ends).max(axis=1), np.maximum(*ends).min(axis=1)
        meets = enters < leaves
        depth = (self._seen(place, rays[meets])[0] - enters[meets]) / (leaves - enters)[meets]
        depth = depth[np.isfinite(depth)]
        is_full = len(depth) > 0 and self.content_share >= _FULL
        return is_full and bool(np.median(depth) < _NEAR_WALL)

    @property
    def _diagonal(self) -> float:
        return float(np.linalg.norm(self.high - self.low))

    def lamp(self, camera: Camera) -> RectangleLight:
        """Return a light below the ceiling, over the middle of what the camera looks at."""
        extent = self.high - self.low
        ahead = math3d.normalized(np.subtract(camera.target, camera.position))
        free = min(
            float(self._seen(np.asarray(camera.position), ahead[None])[0][0]), self._diagonal
        )
        place = camera.position + ahead * min(0.5 * free, camera.distance)
        up = np.array([[0.0, 1.0, 0.0]])
        height = float(self._seen(place, up)[0][0])
        place[1] += min(height, float(self.high[1] - place[1])) - _PANEL_GAP * extent[1]
        side = _PANEL_SHARE * float(min(extent[0], extent[2]))
        drop = max(float(place[1] - self.low[1]), 0.25 * side)
        radiance = _PANEL_COLOR * (_FLOOR_IRRADIANCE * drop**2 / side**2)
        red, green, blue = (float(value) for value in radiance)
        return RectangleLight(
            corner=math3d.vector(place - [0.5 * side, 0.0, 0.5 * side]),
            edge_u=(side, 0.0, 0.0),
            edge_v=(0.0, 0.0, side),
            radiance=(red, green, blue),
            visible=False,
            name="ceiling light",
        )

    def _seen(
        self, origin: FloatArray, directions: FloatArray
    ) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Return what is seen from `origin` (3,) along unit `directions` (N, 3).

        Its distance (N,), infinite where nothing is, and whether it is not of the walls (N,).
        """
        a, b, c = np.moveaxis(self.corners - origin, 1, 0)
        normal = np.cross(b - a, c - a)
        # Volumes that a ray spans with the edges: of one sign where it passes inside.
        sides = [np.cross(p, q) @ directions.T for p, q in ((a, b), (b, c), (c, a))]
        inside = (np.minimum.reduce(sides) >= 0.0) | (np.maximum.reduce(sides) <= 0.0)
        along = normal @ directions.T
        offset = (normal * a).sum(axis=1)[:, None]
        distance = np.where(inside & (along * offset > 0.0), offset, np.inf)
        distance = np.divide(distance, along, out=distance, where=np.isfinite(distance))
        first = distance.argmin(axis=0)
        nearest = distance[first, np.arange(len(directions))]
        return nearest, self.is_content[first] & np.isfinite(nearest)


def interior_of(
    meshes: Sequence[Mesh], objects: Sequence[SceneObject], part: MainPart
) -> Interior | None:
    """Return the room within walls that close `part`; None if there is next to nothing in it."""
    counts = [len(meshes[item.mesh].triangles) * len(item.world_from_object) for item in objects]
    if sum(counts) > _MOST_TRIANGLES:
        return None
    found = [
        placed(meshes[item.mesh].corners(), item.world_from_object).reshape(-1, 3, 3)
        for item in objects
    ]
    corners = np.concatenate(found)
    depth = 0.05 * (part.high - part.low)
    within = ((corners >= part.low - depth) & (corners <= part.high + depth)).all(axis=(1, 2))
    corners = corners[within]
    inside: NDArray[np.bool_] = np.all(
        (corners >= part.low + depth) & (corners <= part.high - depth), axis=2
    )
    is_content = np.asarray(inside.any(axis=1), dtype=bool)
    if is_content.sum() < _FEWEST_TRIANGLES:
        return None
    area = lengths_of_rows(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    largest = np.argsort(-area, kind="stable")[:_MAX_TRIANGLES]
    return Interior(
        part.low, part.high, corners[largest], is_content[largest], float(is_content.mean())
    )


def room_around(
    meshes: Sequence[Mesh], objects: Sequence[SceneObject], camera: Camera
) -> Interior | None:
    """Return the room that the camera stands in, where light from outside hardly comes in."""
    part = main_part(meshes, objects)
    place = np.asarray(camera.position)
    if not ((place > part.low) & (place < part.high)).all():
        return None
    room = interior_of(meshes, objects, part)
    return room if room is not None and room.surrounds(place) else None


def _rays(camera: Camera) -> FloatArray:
    """Return unit directions (N, 3) spread over the camera's picture."""
    x, y = camera.tan_half_fov(16.0 / 9.0)
    across = np.linspace(-0.95, 0.95, _COLUMNS) * x
    up = np.linspace(-0.95, 0.95, _ROWS) * y
    right, high = (grid.reshape(-1) for grid in np.meshgrid(across, up))
    local = np.stack([right, high, -np.ones(len(right))], axis=1)
    return math3d.normalized(local @ camera.view_from_world_rotation())
