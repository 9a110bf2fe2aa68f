"""A camera for a scene that brings none: the whole of it, from a good side."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray, lengths_of_rows
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.defaults.interior import SHELL_TRIANGLES, Interior, interior_of, room_around
from ssdo_gl.scene.geometry import (
    MainPart,
    Mesh,
    Surfaces,
    corners_within,
    main_part,
    placed,
    spans,
)

# Three-quarter view: turned to the right of the front (+z) and slightly above it.
AZIMUTH_DEGREES, ELEVATION_DEGREES = 30.0, 20.0
# Pictures from square to wide must hold the scene, so the square decides.
MARGIN = 1.06
# Above this many vertices the boxes of the instances are framed in their place.
MAX_POINTS = 200_000
# A scene is flat if this much of its area, squared cosines as weights, faces one axis.
# Of things repeated more often than this each is small, whatever its shape.
_FLAT_SHARE, _MAX_SHEETS = 0.95, 64
_TRIANGLES_AT_ONCE = 1 << 18
# A side of the bounding box is a wall if surfaces within a twentieth of the box cover
# most of it, and open if they cover next to nothing.
_WALL_DEPTH, _WALL_COVERAGE, _OPEN_COVERAGE = 0.05, 0.6, 0.1
_ROOM_SIDES, _WINDOW_COVERAGE, _WHOLE_COVERAGE = 5, 0.5, 0.9
# Walls that face inward by so much more than outward are seen from within.
_LINED = 2.0
# A storey without a roof is seen over its walls.
_OVER_WALLS_DEGREES = 55.0
# Sides of the bounding box as rows of coverage: -x +x -y +y -z +z.
_BOTTOM, _TOP = 2, 3
_SIDE_AZIMUTHS = {5: 0.0, 1: 90.0, 4: 180.0, 0: 270.0}


def frame(surfaces: Surfaces, fov_y: float, exposure: float) -> Camera:
    """Return a camera that sees every vertex of the scene's main part.

    It stands in a closed room, and in one of any plan that shows the backs of its walls outside.
    A room with one open side is looked into, level, through that side; something flat that stands
    is seen from its front, thirty degrees to the right. Anything else is seen at three quarters
    from slightly above, from where fewest walls of it stand in the way; the front is +z. Where
    walls hide the floor of what has no roof, it is seen from higher up.

    Parameters
    ----------
    fov_y : float
        Vertical field of view in degrees.
    """
    front = _front_of_sheet(surfaces)
    if front is not None:
        return seen_from(surfaces, _toward(*front), fov_y, exposure)
    sides = wall_sides(surfaces)
    room = closed_room(surfaces, sides)
    drawn = _drawn_walls(surfaces, sides)
    azimuth, elevation = _viewpoint(_coverage(sides), drawn)
    camera = seen_from(surfaces, _toward(azimuth, elevation), fov_y, exposure)
    if room is None and int((_coverage(sides) >= _WALL_COVERAGE).sum()) == _ROOM_SIDES:
        # What looks open is not, where something sticks out of a wall.
        room = interior_of(surfaces._replace(materials=()), main_part(surfaces))
        room = room if room is not None and room.hides_from(camera) else None
    if room is not None:
        return room.camera(fov_y, exposure)
    if _opening(_coverage(sides)) is not None:
        return camera
    shell = interior_of(surfaces, main_part(surfaces), SHELL_TRIANGLES)
    if shell is None:
        return camera
    if shell.is_inside_out():
        return shell.wide_camera(fov_y, exposure) or camera
    above = seen_from(surfaces, _toward(azimuth, _OVER_WALLS_DEGREES), fov_y, exposure)
    return above if shell.shows_its_floor_to(above, camera) else camera


def _toward(azimuth: float, elevation: float) -> FloatArray:
    a, e = np.radians([azimuth, elevation])
    return np.array([np.sin(a) * np.cos(e), np.sin(e), np.cos(a) * np.cos(e)])


def seen_from(surfaces: Surfaces, toward: FloatArray, fov_y: float, exposure: float) -> Camera:
    """Return the nearest camera in the direction `toward` (3,) that sees the main part."""
    return _around(_world_points(surfaces), toward, fov_y, exposure)


def parallel(surfaces: Surfaces, camera: Camera, height: float | None) -> Camera:
    """Return the camera with parallel rays, moved so that it sees the main part.

    Parameters
    ----------
    height : float or None
        What the picture shows, scene units; None: as much as is needed.
    """
    rotation = camera.view_from_world_rotation()
    points = _world_points(surfaces)
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    local = (points - middle) @ rotation.T
    low, high = local.min(axis=0), local.max(axis=0)
    needed = MARGIN * float((high - low)[:2].max())
    target = middle + rotation.T @ (0.5 * (low + high))
    distance = 0.5 * float(high[2] - low[2]) + needed
    return dataclasses.replace(
        camera,
        position=math3d.vector(target + rotation[2] * distance),
        target=math3d.vector(target),
        height=height or needed,
    )


def _front_of_sheet(surfaces: Surfaces) -> tuple[float, float] | None:
    """Return azimuth and elevation from which something flat is seen well.

    None if the scene is not flat, or lies face up. The front is the one that the winding
    faces; of a sheet with two fronts, or a thin body, the one towards +z or +x. What lies on
    its face is seen from below, where its back is not drawn.
    """
    total, area = np.zeros(3), 0.0
    squares = np.zeros((3, 3))
    for item in surfaces.objects:
        mesh, linear = surfaces.mesh(item), item.world_from_object[:, :3, :3]
        scale = float(np.abs(mesh.bounds()).max()) or 1.0
        for span in spans(len(mesh.triangles)):
            corners = mesh.corners(span)
            edges = (corners[:, 1:] - corners[:, :1]) / scale
            for matrix in linear[:_MAX_SHEETS]:
                u, v = np.moveaxis(edges @ matrix.T, 1, 0) * scale
                cross = np.cross(u, v)
                size = lengths_of_rows(cross)
                total += cross.sum(axis=0)
                area += float(size.sum())
                squares += cross.T @ (cross / np.where(size > 0.0, size, 1.0)[:, None])
        if len(linear) > _MAX_SHEETS:
            return None
    if not np.isfinite(area) or area <= 0.0:
        return None
    share, axes = np.linalg.eigh(squares / area)
    if share[2] < _FLAT_SHARE:
        return None
    front = axes[:, 2]
    facing = float(total @ front) / area
    # A sheet says which side is its front; a thin body shows both.
    upright = front[[2, 0]] if abs(front[2]) > 0.5 else front[[0, 2]]
    if facing < -0.5 or (abs(facing) <= 0.5 and upright[0] < 0.0):
        front = -front
    if np.hypot(front[0], front[2]) < 0.5:
        is_hidden = all(map(surfaces.is_single_sided, surfaces.objects)) and abs(facing) > 0.5
        return (AZIMUTH_DEGREES, -ELEVATION_DEGREES) if is_hidden and front[1] < 0.0 else None
    azimuth = float(np.degrees(np.arctan2(front[0], front[2])))
    return azimuth + AZIMUTH_DEGREES, ELEVATION_DEGREES


def _opening(coverage: FloatArray) -> int | None:
    """Return the one side through which a room is looked into, if there is one."""
    walls = coverage >= _WALL_COVERAGE
    lateral = list(_SIDE_AZIMUTHS)
    # In a box with a window one side is open, if the others are whole.
    least = lateral[int(np.argmin(coverage[lateral]))]
    others = np.delete(coverage, least)
    limit = _WINDOW_COVERAGE if others.min() >= _WHOLE_COVERAGE else _OPEN_COVERAGE
    openings = [side for side in lateral if coverage[side] < limit]
    is_room = len(openings) == 1 and walls[lateral].sum() == 3 and walls[_BOTTOM]
    return openings[0] if is_room else None


def _drawn_walls(surfaces: Surfaces, sides: FloatArray) -> FloatArray:
    """Return the part of the coverage of the `sides` (2, 6) that is drawn from outside, (6,)."""
    single = [item for item in surfaces.objects if surfaces.is_single_sided(item)]
    if not single:
        return _coverage(sides)
    culled = wall_sides(surfaces._replace(objects=single), main_part(surfaces))[1]
    return _coverage(sides - [np.zeros(6), culled])


def _viewpoint(coverage: FloatArray, drawn: FloatArray) -> tuple[float, float]:
    """Return azimuth (0 is +z, 90 is +x) and elevation in degrees.

    Parameters
    ----------
    drawn : ndarray, shape (6,)
        How much of `coverage` is drawn from outside: through the rest one sees.
    """
    walls = coverage >= _WALL_COVERAGE
    lateral = list(_SIDE_AZIMUTHS)
    opening = _opening(coverage)
    if opening is not None:
        return _SIDE_AZIMUTHS[opening], 0.0 if walls[_TOP] else ELEVATION_DEGREES

    def blocked(azimuth: float) -> float:
        # Walls count by how squarely the view would run into them.
        return sum(
            max(float(np.cos(np.radians(azimuth - _SIDE_AZIMUTHS[side]))), 0.0)
            for side in lateral
            if drawn[side] >= _WALL_COVERAGE
        )

    candidates = [
        front + turn * AZIMUTH_DEGREES for front in (0.0, 90.0, 270.0, 180.0) for turn in (1, -1)
    ]
    # The first of equals: the front, from the right.
    azimuth = min(candidates, key=lambda azimuth: round(blocked(azimuth), 6))
    # Below a roof one looks through walls that are not drawn.
    is_roofed = drawn[_TOP] >= _WALL_COVERAGE and blocked(azimuth) == 0.0
    return azimuth, 0.0 if is_roofed and walls[lateral].all() else ELEVATION_DEGREES


def closed_room(surfaces: Surfaces, sides: FloatArray) -> Interior | None:
    """Return the room that a scene is, if walls on all of its `sides` face inward."""
    outward, inward = sides
    lateral = list(_SIDE_AZIMUTHS)
    is_lined = inward >= np.maximum(_WALL_COVERAGE, _LINED * outward)
    if not (is_lined[lateral].all() and (_coverage(sides) >= _WALL_COVERAGE).all()):
        return None
    return interior_of(surfaces._replace(materials=()), main_part(surfaces))


def is_room(surfaces: Surfaces, camera: Camera) -> bool:
    """Return whether the camera sees the inside of a room, where no sky belongs.

    Walls then cover five sides of the bounding box, or all six around the camera: seen from
    outside that is a solid. Of a room that is no box they are all around the camera.
    """
    part = main_part(surfaces)
    is_inside = bool(np.all((camera.position > part.low) & (camera.position < part.high)))
    count = int((side_coverage(surfaces) >= _WALL_COVERAGE).sum())
    if count == _ROOM_SIDES:
        return True
    return is_inside and (count == 6 or room_around(surfaces, camera) is not None)


def side_coverage(surfaces: Surfaces) -> FloatArray:
    """Return how much of each side of the main part's box has a surface close to it.

    Returns
    -------
    ndarray, shape (6,)
        For the sides -x +x -y +y -z +z: area of the triangles that lie wholly within
        a twentieth of the box from the side, projected on it, over its area; at most 1.
    """
    return _coverage(wall_sides(surfaces))


def _coverage(sides: FloatArray) -> FloatArray:
    return np.asarray(np.minimum(sides.sum(axis=0), 1.0))


def wall_sides(surfaces: Surfaces, part: MainPart | None = None) -> FloatArray:
    """Return what `side_coverage` counts, of what faces out and in, (2, 6), without limit.

    Of the sides of `part`, or of the main part of the objects.
    """
    boxes = surfaces.boxes()
    part = part or main_part(surfaces)
    low, high = part.low, part.high
    extent = high - low
    # Only instances that reach a side can cover it.
    reaches = (boxes.min(axis=1) <= low + _WALL_DEPTH * extent).any(axis=1)
    reaches |= (boxes.max(axis=1) >= high - _WALL_DEPTH * extent).any(axis=1)
    covered = np.zeros((2, 6))
    first = 0
    for item in surfaces.objects:
        mesh, count = surfaces.mesh(item), len(item.world_from_object)
        matrices = item.world_from_object[reaches[first : first + count]]
        first += count
        at_once = max(_TRIANGLES_AT_ONCE // len(mesh.triangles), 1)
        for start in range(0, len(matrices), at_once):
            points = placed(mesh.positions, matrices[start : start + at_once])
            for axis in range(3):
                height = points[..., axis]
                depth = _WALL_DEPTH * extent[axis]
                at_low, at_high = height <= low[axis] + depth, height >= high[axis] - depth
                if not part.is_all:
                    at_low &= height >= low[axis] - depth
                    at_high &= height <= high[axis] + depth
                covered[::-1, 2 * axis] += _projected_area(points, mesh, at_low, axis)
                covered[:, 2 * axis + 1] += _projected_area(points, mesh, at_high, axis)
    side = np.array([extent[1] * extent[2], extent[0] * extent[2], extent[0] * extent[1]])
    # A flat scene has sides without area, which nothing can cover.
    return np.asarray(covered / np.repeat(np.where(side > 0.0, side, np.inf), 2))


def _projected_area(
    points: FloatArray, mesh: Mesh, is_near: NDArray[np.bool_], axis: int
) -> FloatArray:
    """Return the area, seen along an axis, of triangles whose vertices (N, V) are all near.

    Of those that face along the axis, and of those that face against it, (2,).
    """
    corners = corners_within(points, mesh.triangles, is_near)
    along = math3d.doubled_area_vectors(corners)[:, axis]
    return 0.5 * np.array([along[along > 0.0].sum(), -along[along < 0.0].sum()])


def _world_points(surfaces: Surfaces) -> FloatArray:
    """Return what a camera is to show: vertices in world space, or the corners of boxes."""
    part = main_part(surfaces)
    points = _all_points(surfaces)
    if part.is_all:
        return points
    # What a box of many instances reaches beyond the main part is not shown.
    inside = ((points >= part.low) & (points <= part.high)).all(axis=1)
    corners = np.where(np.indices((2, 2, 2)).reshape(3, 8).T == 1, part.high, part.low)
    return points[inside] if len(points) <= MAX_POINTS and inside.any() else corners


def _all_points(surfaces: Surfaces) -> FloatArray:
    total = sum(
        len(surfaces.mesh(o).positions) * len(o.world_from_object) for o in surfaces.objects
    )
    if total > MAX_POINTS:
        return surfaces.boxes().reshape(-1, 3)
    return np.concatenate(
        [
            math3d.transform_points(matrix, surfaces.mesh(item).positions)
            for item in surfaces.objects
            for matrix in item.world_from_object
        ]
    )


def _around(points: FloatArray, toward: FloatArray, fov_y: float, exposure: float) -> Camera:
    """Return the nearest camera along `toward` that holds all points in its view."""
    rotation = math3d.look_rotation(toward, np.zeros(3), (0.0, 1.0, 0.0))
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    local = (points - middle) @ rotation.T
    slope = float(np.tan(np.radians(fov_y) / 2.0)) / MARGIN
    # A point is inside when |x - cx| <= slope (d - z): each side of the frame gives
    # one bound, and opposite sides fix the centre that needs the least distance.
    center = []
    distance = 0.0
    for axis in range(2):
        right = float(np.max(local[:, axis] + slope * local[:, 2]))
        left = float(np.max(-local[:, axis] + slope * local[:, 2]))
        center.append(0.5 * (right - left))
        distance = max(distance, 0.5 * (right + left) / slope)
    target = middle + rotation.T @ np.array([center[0], center[1], 0.0])
    position = target + rotation[2] * distance
    return Camera(math3d.vector(position), math3d.vector(target), (0.0, 1.0, 0.0), fov_y, exposure)
