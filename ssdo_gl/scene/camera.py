"""The camera of a scene: a pinhole, or parallel rays."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray

# The second and third are the same.
PROJECTIONS = ("perspective", "orthographic", "ortho")


@dataclass(frozen=True)
class Camera:
    """A camera in world space (right-handed, scene units).

    Attributes
    ----------
    position, target, up : tuple of 3 floats
        World space. `target` is the point in the middle of the picture.
    fov_y : float
        Vertical field of view in degrees, (0, 180).
    exposure : float
        Exposure in EV applied before tone mapping; 0 leaves radiance as it is.
    height : float or None
        Of what the picture shows, scene units, if rays are parallel (an orthographic
        camera); nothing behind `position` is seen. None: a pinhole camera.
    """

    position: tuple[float, float, float]
    target: tuple[float, float, float]
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)
    fov_y: float = 40.0
    exposure: float = 0.0
    height: float | None = None

    @property
    def distance(self) -> float:
        """From the camera to its target, scene units."""
        return math.dist(self.position, self.target)

    @property
    def height_at_target(self) -> float:
        """Height of what the picture shows at the distance of the target, scene units."""
        if self.height is not None:
            return self.height
        return 2.0 * self.distance * math.tan(math.radians(self.fov_y) / 2.0)

    def orthographic(self, height: float | None = None) -> Camera:
        """Return the camera with parallel rays; what is at its target keeps its size.

        Parameters
        ----------
        height : float or None
            What the picture shows instead, scene units.
        """
        return dataclasses.replace(self, height=height or self.height_at_target)

    def perspective(self) -> Camera:
        """Return the pinhole camera that shows what is at the target as large.

        It keeps its field of view and comes nearer or draws back.
        """
        if self.height is None:
            return self
        ahead = np.subtract(self.target, self.position) / self.distance
        distance = self.height / (2.0 * math.tan(math.radians(self.fov_y) / 2.0))
        position = math3d.vector(np.asarray(self.target) - ahead * distance)
        return dataclasses.replace(self, position=position, height=None)

    def view_from_world_rotation(self) -> FloatArray:
        """Return the (3, 3) rotation from world to view space (looks along -z)."""
        return math3d.look_rotation(self.position, self.target, self.up)

    def tan_half_fov(self, aspect: float) -> tuple[float, float]:
        """Return tangents of half the (horizontal, vertical) field of view; 0 if parallel.

        Parameters
        ----------
        aspect : float
            Width over height of the picture.
        """
        if self.height is not None:
            return 0.0, 0.0
        vertical = float(np.tan(np.radians(self.fov_y) / 2.0))
        return vertical * aspect, vertical

    def half_frame(self, aspect: float) -> tuple[float, float]:
        """Return half of the (width, height) that parallel rays show; 0 for a pinhole."""
        vertical = 0.5 * (self.height or 0.0)
        return vertical * aspect, vertical
