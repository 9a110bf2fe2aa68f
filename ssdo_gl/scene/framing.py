"""A camera for a scene that brings none: the whole of it, from a good side."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.mesh import Mesh, SceneObject

# Three-quarter view: turned to the right of the front (+z) and slightly above it.
AZIMUTH_DEGREES, ELEVATION_DEGREES = 30.0, 20.0
# Pictures from square to 16:9 must hold the scene, so the square decides.
MARGIN = 1.06
# At most this many points are projected; more would not move the frame by a pixel.
MAX_POINTS = 200_000


def frame(
    meshes: Sequence[Mesh], objects: Sequence[SceneObject], fov_y: float, exposure: float
) -> Camera:
    """Return a camera that sees every vertex of the scene.

    Parameters
    ----------
    fov_y : float
        Vertical field of view in degrees.
    """
    points = world_points(meshes, objects)
    toward = _view_direction(AZIMUTH_DEGREES, ELEVATION_DEGREES)
    return _around(points, toward, fov_y, exposure)


def world_points(meshes: Sequence[Mesh], objects: Sequence[SceneObject]) -> FloatArray:
    """Return vertices of all instances in world space, thinned evenly if many."""
    total = sum(len(meshes[o.mesh].positions) * len(o.world_from_object) for o in objects)
    stride = max(total // MAX_POINTS, 1)
    chunks = []
    for item in objects:
        mesh = meshes[item.mesh]
        low, high = mesh.bounds()
        corners = np.where(np.indices((2, 2, 2)).reshape(3, 8).T, high, low)
        points = corners if stride > 1 else mesh.positions[np.unique(mesh.triangles)]
        for matrix in item.world_from_object:
            chunks.append(math3d.transform_points(matrix, points))
    return np.concatenate(chunks)


def _view_direction(azimuth: float, elevation: float) -> FloatArray:
    a, e = np.radians([azimuth, elevation])
    return np.array([np.sin(a) * np.cos(e), np.sin(e), np.cos(a) * np.cos(e)])


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
    return Camera(_tuple(position), _tuple(target), (0.0, 1.0, 0.0), fov_y, exposure)


def _tuple(array: FloatArray) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in array)
    return x, y, z
