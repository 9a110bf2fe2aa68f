"""A place to stand and a light for a closed room, of which the outside shows nothing."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray, doubled_area_vectors, lengths_of_rows
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry import MainPart, Surfaces, main_part, placed
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
# Places in a room of any plan, along each of its box's sides; headings from each of them, rows of
# rays, and how many headings a picture is wide.
_PLACES, _HEADINGS, _TILTS, _PICTURE_HEADINGS = 5, 36, (-0.35, 0.0, 0.35), 9
# Such a room is turned inside out: so much of what is seen from so many sides, a little from above,
# shows its back.
_BACKS, _SIDES, _SLOPE = 0.7, 8, 0.3
# It has a floor, so large a share of its plan; a body whose faces are wound inward has none.
_LEAST_FLOOR = 0.3
# It encloses so large a share of its box; most bodies less.
_LEAST_SPACE = 0.25
# Of more triangles the larger ones tell that.
SHELL_TRIANGLES = 1 << 13
# A room is hidden where half of what is seen from outside is a wall within this share of the
# way through it; it is full where so many of its triangles are not of the walls.
_NEAR_WALL, _FULL = 0.25, 0.9
# A storey without a roof is no higher than this share of its width, what is as low as that share of
# its height is floor, and its walls hide it where one sees less than the one and, from above, more
# than the other share.
_FLAT, _FLOOR, _NO_FLOOR, _MUCH_FLOOR, _LEVEL = 0.5, 0.15, 0.05, 0.15, 0.9
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
    single_sided : ndarray, shape (T,)
        Whether their backs are not drawn.
    content_share : float
        Of all triangles.
    """

    low: FloatArray
    high: FloatArray
    corners: FloatArray
    is_content: NDArray[np.bool_]
    single_sided: NDArray[np.bool_]
    content_share: float

    def camera(self, fov_y: float, exposure: float) -> Camera:
        """Return the camera near the walls, level, that sees far and most of what is there."""
        extent, middle = self.high - self.low, 0.5 * (self.low + self.high)
        cameras = []
        for x, z in itertools.product((-1.0, 0.0, 1.0), (1.0, 0.0, -1.0)):
            position = middle + (0.5 - _INSET) * extent * [x, 0.0, z]
            position[1] = self.low[1] + _EYE_HEIGHT * extent[1]
            target = middle * [1.0, 0.0, 1.0] + position * [0.0, 1.0, 0.0]
            if x or z:
                cameras.append(_level_camera(position, target, fov_y, exposure))
        return max(cameras, key=lambda c: self._worth(np.array(c.position), _rays(c))[0].mean())

    def is_inside_out(self) -> bool:
        """Return whether it has floor and space and shows most places outside its walls' backs."""
        if self._space() < _LEAST_SPACE * float(np.prod(self.high - self.low)):
            return False
        if self._floor_area() < _LEAST_FLOOR * float(np.prod((self.high - self.low)[[0, 2]])):
            return False
        steps = np.array([0.1, 0.5, 0.9])
        grid = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3)
        points = self.low + (self.high - self.low) * grid
        middle, count, seen = 0.5 * (self.low + self.high), 0, 0
        for side in range(_SIDES):
            # Opposite ones follow each other: four of them tell of a body that it is none.
            if side == _SIDES // 2 and count < 0.5 * _BACKS * seen:
                return False
            turn = np.pi * (side % 2 + side // 2 * 2.0 / _SIDES)
            toward = np.array([np.cos(turn), _SLOPE, np.sin(turn)])
            place = middle + 2.0 * self._diagonal * toward
            directions = math3d.normalized(points - place)
            distance, first = self._hits(place, directions, culls=True)
            is_seen = np.isfinite(distance)
            seen += int(is_seen.sum())
            count += int((self._backs(first, directions) & is_seen).sum())
        return count >= _BACKS * max(seen, 1)

    def wide_camera(self, fov_y: float, exposure: float) -> Camera | None:
        """Return the camera that sees far and much, level, in a room of any plan; None if none.

        It stands where fronts are seen all around.
        """
        turn = 2.0 * np.pi * np.arange(_HEADINGS) / _HEADINGS
        level = np.stack([np.sin(turn), np.zeros(_HEADINGS), -np.cos(turn)], axis=1)
        tilted = level[:, None] + np.array(_TILTS)[None, :, None] * [0.0, 1.0, 0.0]
        rays = math3d.normalized(tilted.reshape(-1, 3))
        window = np.arange(_PICTURE_HEADINGS) - _PICTURE_HEADINGS // 2
        best, chosen = -np.inf, None
        steps = np.linspace(_INSET, 1.0 - _INSET, _PLACES)
        for x, z in ((x, z) for x in steps for z in steps[::-1]):
            place = self.low + (self.high - self.low) * [x, _EYE_HEIGHT, z]
            if not self.surrounds(place, fronts=True):
                continue
            worth, far = self._worth(place, rays)
            each = worth.reshape(_HEADINGS, -1).mean(axis=1)
            score = each[(np.arange(_HEADINGS)[:, None] + window) % _HEADINGS].mean(axis=1)
            heading = int(score.argmax())
            if score[heading] > best:
                ahead = far.reshape(_HEADINGS, -1)[heading, 1] * self._diagonal
                best, chosen = float(score[heading]), (place, level[heading] * 0.5 * ahead)
        if chosen is None:
            return None
        position, arm = chosen
        return _level_camera(position, position + arm, fov_y, exposure)

    def surrounds(self, place: FloatArray, *, fronts: bool = False) -> bool:
        """Return whether one sees walls, or only their `fronts`, nearly all around a place (3,)."""
        around = math3d.spread_directions(_DIRECTIONS)
        distance, first = self._hits(place, around)
        seen = np.isfinite(distance)
        if fronts:
            seen &= ~self._backs(first, around)
        return float(seen.mean()) >= _SURROUNDED

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

    def shows_its_floor_to(self, above: Camera, camera: Camera) -> bool:
        """Return whether a wide place without a roof shows its floor to the first camera alone."""
        width, height, depth = self.high - self.low
        if height > _FLAT * min(width, depth):
            return False
        return self._floor_to(camera) < _NO_FLOOR and self._floor_to(above) > _MUCH_FLOOR

    def _floor_to(self, camera: Camera) -> float:
        """Return how much of what a camera sees is floor."""
        rays, place = _rays(camera), np.asarray(camera.position)
        distance, first = self._hits(place, rays, culls=True)
        seen = np.isfinite(distance)
        heights = place[1] + distance[seen] * rays[seen, 1] - self.low[1]
        a, b, c = np.moveaxis(self.corners[first[seen]], 1, 0)
        is_level = np.abs(math3d.normalized(np.cross(b - a, c - a))[:, 1]) > _LEVEL
        is_floor = is_level & (heights < _FLOOR * (self.high[1] - self.low[1]))
        return float(is_floor.sum()) / max(len(heights), 1)

    def _space(self) -> float:
        """Return the volume before the fronts; of missing walls as much as the middle tells."""
        a, b, c = np.moveaxis(self.corners - 0.5 * (self.low + self.high), 1, 0)
        return float(np.einsum("ij,ij->", a, np.cross(c, b))) / 6.0

    def _floor_area(self) -> float:
        """Return the area of what is level and low, fronts and backs alike."""
        a, b, c = np.moveaxis(self.corners, 1, 0)
        normal = np.cross(b - a, c - a)
        area = lengths_of_rows(normal)
        heights = self.corners[..., 1].max(axis=1) - self.low[1]
        is_low = heights < _FLOOR * (self.high[1] - self.low[1])
        return 0.5 * float(area[is_low & (np.abs(normal[:, 1]) > _LEVEL * area)].sum())

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

    def _worth(self, origin: FloatArray, directions: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what rays as of `_seen` add to a picture's worth (N,), and how far they go (N,).

        As a share of the diagonal. Of distances the logarithm counts: what is close hides much.
        """
        distance, shows = self._seen(origin, directions)
        far = np.clip(distance / self._diagonal, 1e-3, 1.0)
        return np.log(far) + _CONTENT_WEIGHT * (shows & (far > _TOO_NEAR)), far

    def _seen(
        self, origin: FloatArray, directions: FloatArray
    ) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Return what is seen from `origin` (3,) along unit `directions` (N, 3).

        Its distance (N,), infinite where nothing is, and whether it is not of the walls (N,).
        """
        nearest, first = self._hits(origin, directions)
        return nearest, self.is_content[first] & np.isfinite(nearest)

    def _hits(
        self, origin: FloatArray, directions: FloatArray, *, culls: bool = False
    ) -> tuple[FloatArray, NDArray[np.int64]]:
        """Return distance (N,) and triangle (N,) of what unit `directions` (N, 3) meet first.

        With `culls` backs that are not drawn are passed through.
        """
        a, b, c = np.moveaxis(self.corners - origin, 1, 0)
        normal = np.cross(b - a, c - a)
        # Volumes that a ray spans with the edges: of one sign where it passes inside.
        sides = [np.cross(p, q) @ directions.T for p, q in ((a, b), (b, c), (c, a))]
        inside = (np.minimum.reduce(sides) >= 0.0) | (np.maximum.reduce(sides) <= 0.0)
        along = normal @ directions.T
        if culls:
            inside &= ~(self.single_sided[:, None] & (along > 0.0))
        offset = (normal * a).sum(axis=1)[:, None]
        distance = np.where(inside & (along * offset > 0.0), offset, np.inf)
        distance = np.divide(distance, along, out=distance, where=np.isfinite(distance))
        first = distance.argmin(axis=0)
        return distance[first, np.arange(len(directions))], first

    def _backs(self, first: NDArray[np.int64], directions: FloatArray) -> NDArray[np.bool_]:
        """Return whether rays (N, 3) meet the backs of triangles (N,)."""
        a, b, c = np.moveaxis(self.corners[first], 1, 0)
        return np.asarray((np.cross(b - a, c - a) * directions).sum(axis=1) > 0.0)


def interior_of(
    surfaces: Surfaces, part: MainPart, most: int = _MAX_TRIANGLES, fewest: int = _FEWEST_TRIANGLES
) -> Interior | None:
    """Return the room within walls that close `part`.

    None if it has fewer triangles than `fewest` in it, or too many to look at.
    """
    counts = [
        len(surfaces.mesh(item).triangles) * len(item.world_from_object)
        for item in surfaces.objects
    ]
    if sum(counts) > _MOST_TRIANGLES:
        return None
    found = [
        placed(surfaces.mesh(item).corners(), item.world_from_object).reshape(-1, 3, 3)
        for item in surfaces.objects
    ]
    corners = np.concatenate(found)
    sided = [surfaces.is_single_sided(item) for item in surfaces.objects]
    single_sided = np.repeat(sided, [len(triangles) for triangles in found])
    depth = 0.05 * (part.high - part.low)
    within = ((corners >= part.low - depth) & (corners <= part.high + depth)).all(axis=(1, 2))
    corners, single_sided = corners[within], single_sided[within]
    inside: NDArray[np.bool_] = np.all(
        (corners >= part.low + depth) & (corners <= part.high - depth), axis=2
    )
    is_content = np.asarray(inside.any(axis=1), dtype=bool)
    if is_content.sum() < fewest or not len(corners):
        return None
    area = lengths_of_rows(doubled_area_vectors(corners))
    largest = np.argsort(-area, kind="stable")[:most]
    return Interior(
        part.low,
        part.high,
        corners[largest],
        is_content[largest],
        single_sided[largest],
        float(is_content.mean()),
    )


def room_around(surfaces: Surfaces, camera: Camera) -> Interior | None:
    """Return the room that the camera stands in, where light from outside hardly comes in."""
    part = main_part(surfaces)
    place = np.asarray(camera.position)
    if not ((place > part.low) & (place < part.high)).all():
        return None
    room = interior_of(surfaces._replace(materials=()), part, fewest=0)
    return room if room is not None and room.surrounds(place) else None


def _level_camera(
    position: FloatArray, target: FloatArray, fov_y: float, exposure: float
) -> Camera:
    place, aim = math3d.vector(position), math3d.vector(target)
    return Camera(place, aim, fov_y=max(fov_y, ROOM_FOV_DEGREES), exposure=exposure)


def _rays(camera: Camera) -> FloatArray:
    """Return unit directions (N, 3) spread over the camera's picture."""
    x, y = camera.tan_half_fov(16.0 / 9.0)
    across = np.linspace(-0.95, 0.95, _COLUMNS) * x
    up = np.linspace(-0.95, 0.95, _ROWS) * y
    right, high = (grid.reshape(-1) for grid in np.meshgrid(across, up))
    local = np.stack([right, high, -np.ones(len(right))], axis=1)
    return math3d.normalized(local @ camera.view_from_world_rotation())
