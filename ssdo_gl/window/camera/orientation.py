"""Yaw and pitch in a scene whose "up" may be any direction. Pure, float64.

Plain tuples of floats: a flight takes a handful of these steps for every frame, and
arrays of three numbers cost more to make than to compute with.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import Vector, add, dot, vector
from ssdo_gl.scene.camera import Camera


@dataclass(frozen=True)
class Axes:
    """What "up" and yaw 0 mean in a scene: a right-handed orthonormal frame.

    `ahead` is where yaw 0 looks; positive yaw turns towards `left`.
    """

    up: Vector
    ahead: Vector
    left: Vector

    def forward(self, yaw: float, pitch: float) -> Vector:
        """Return the unit viewing direction, world space; angles in radians."""
        c, s = math.cos(pitch), math.sin(pitch)
        a, b = c * math.cos(yaw), c * math.sin(yaw)
        x, y, z = (
            a * ahead + b * left + s * up
            for ahead, left, up in zip(self.ahead, self.left, self.up, strict=True)
        )
        return x, y, z

    def right(self, yaw: float) -> Vector:
        """Return the unit direction to the right, perpendicular to `up`."""
        c, s = math.cos(yaw), math.sin(yaw)
        x, y, z = (s * ahead - c * left for ahead, left in zip(self.ahead, self.left, strict=True))
        return x, y, z

    def frame(self, yaw: float, pitch: float) -> tuple[Vector, Vector, Vector]:
        """Return the camera's own right, up and forward in world space."""
        up = self.forward(yaw, pitch + 0.5 * math.pi)
        return self.right(yaw), up, self.forward(yaw, pitch)

    def angles(self, direction: Vector, near_yaw: float) -> tuple[float, float]:
        """Return (yaw, pitch) of a direction, yaw the equivalent nearest to `near_yaw`."""
        ahead, left, up = (dot(axis, direction) for axis in (self.ahead, self.left, self.up))
        flat = math.hypot(ahead, left)
        yaw = math.atan2(left, ahead) if flat > 1e-12 * abs(up) else near_yaw
        yaw += 2.0 * math.pi * round((near_yaw - yaw) / (2.0 * math.pi))
        return yaw, math.atan2(up, flat)


def axes_of(camera: Camera) -> tuple[Axes, float]:
    """Return the axes in which `camera` looks at yaw 0, and its pitch in radians."""
    view_from_world = camera.view_from_world_rotation()
    up = math3d.normalized(camera.up)
    # The camera's right is perpendicular to `up`, but for rounding, unless it looks
    # along `up` and another axis had to stand in for it.
    right = view_from_world[0] - up * (view_from_world[0] @ up)
    if np.linalg.norm(right) < 1e-6:
        right = math3d.frame_from_z(up)[:, 0]
    right = math3d.normalized(right)
    axes = Axes(vector(up), vector(np.cross(up, right)), vector(-right))
    pitch = math.asin(max(-1.0, min(1.0, float(-view_from_world[2] @ up))))
    return axes, pitch


def direction_point(camera: Camera, uv: tuple[float, float], aspect: float) -> Vector:
    """Return the point seen at `uv`, 0..1 from the top left, at the depth of the target."""
    reach = camera.distance
    across, upwards = (
        reach * tangent + half
        for tangent, half in zip(
            camera.tan_half_fov(aspect), camera.half_frame(aspect), strict=True
        )
    )
    place_vs = np.array([(2.0 * uv[0] - 1.0) * across, (1.0 - 2.0 * uv[1]) * upwards, -reach])
    place_ws = place_vs @ camera.view_from_world_rotation()
    return add(vector(camera.position), vector(place_ws))
