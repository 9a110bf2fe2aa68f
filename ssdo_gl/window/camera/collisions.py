"""Keeps a flight out of walls, for those who ask for it. Pure, float64.

Every triangle is tried: a flight casts a handful of rays a frame, for which even a
hundred thousand triangles are a few milliseconds of NumPy, and no structure has to be
built or kept in step with an edited scene.
"""

from __future__ import annotations

import math

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray, Vector, add, difference, dot, vector
from ssdo_gl.scene.scene import Scene

# With more of them a frame would be spent on rays instead of on the picture.
MOST_TRIANGLES = 200_000
# Distance kept from surfaces, in scene diagonals: near enough to look at a detail, and
# ten times what a step at full speed goes at 60 frames a second.
KEEP_AWAY = 0.02
# A corner of three walls stops a slide after this many.
MOST_SLIDES = 3


class Obstacles:
    """The triangles of a scene, to bump into.

    Parameters
    ----------
    scene : Scene
        As it stands; a moving one is taken where it is now.

    Raises
    ------
    ValueError
        If there are too many triangles to try them all.
    """

    def __init__(self, scene: Scene) -> None:
        if scene.triangle_count > MOST_TRIANGLES:
            raise ValueError(
                f"{scene.triangle_count} triangles are too many to bump into "
                f"(up to {MOST_TRIANGLES})"
            )
        corners = [
            math3d.transform_points(matrix, mesh.positions)[mesh.triangles]
            for item in scene.objects
            for mesh in [scene.meshes[item.mesh]]
            for matrix in item.world_from_object
        ]
        triangles: FloatArray = np.concatenate(corners) if corners else np.zeros((0, 3, 3))
        self._start = triangles[:, 0]
        self._edge_1 = triangles[:, 1] - triangles[:, 0]
        self._edge_2 = triangles[:, 2] - triangles[:, 0]
        self._normal = np.cross(self._edge_1, self._edge_2)

    def hit(self, origin: Vector, direction: Vector) -> tuple[float, Vector] | None:
        """Return (distance, unit normal facing the ray) of the nearest triangle.

        Parameters
        ----------
        direction : Vector
            Unit length; both sides of a triangle stop it.
        """
        # Moeller and Trumbore 1997, for all triangles at once.
        d = np.asarray(direction)
        p = np.cross(d, self._edge_2)
        determinant = np.einsum("ij,ij->i", self._edge_1, p)
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = 1.0 / determinant
            offset = np.asarray(origin) - self._start
            u = np.einsum("ij,ij->i", offset, p) * inverse
            q = np.cross(offset, self._edge_1)
            v = (q @ d) * inverse
            t = np.einsum("ij,ij->i", self._edge_2, q) * inverse
            inside = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t > 0.0) & np.isfinite(t)
        if not inside.any():
            return None
        nearest = int(np.argmin(np.where(inside, t, np.inf)))
        normal = math3d.normalized(self._normal[nearest])
        normal = -normal if normal @ d > 0.0 else normal
        return float(t[nearest]), vector(normal)

    def moved(self, start: Vector, end: Vector, keep_away: float) -> Vector:
        """Return where a step from `start` to `end` leads, sliding along what is in the way.

        Parameters
        ----------
        keep_away : float
            Distance kept from surfaces, scene units. Who is nearer already may leave.
        """
        position, way = start, difference(end, start)
        for _ in range(MOST_SLIDES):
            length = math.hypot(*way)
            if length < 1e-9 * keep_away:
                return position
            direction = (way[0] / length, way[1] / length, way[2] / length)
            hit = self.hit(position, direction)
            if hit is None:
                return add(position, way)
            distance, normal = hit
            # How fast the surface comes nearer along the way: 1 head-on, 0 alongside.
            approach = -dot(direction, normal)
            free = distance - keep_away / max(approach, 1e-6)
            if length <= free:
                return add(position, way)
            free = max(free, 0.0)
            position = add(position, direction, free)
            rest = add((0.0, 0.0, 0.0), direction, length - free)
            # What would go into the surface is left out of the rest of the way.
            way = add(rest, normal, -dot(rest, normal))
        return position
