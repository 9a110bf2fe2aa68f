"""The pinhole camera of a scene."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray


@dataclass(frozen=True)
class Camera:
    """A pinhole camera in world space (right-handed, scene units).

    Attributes
    ----------
    position, target, up : tuple of 3 floats
        World space. `target` is the point in the middle of the picture.
    fov_y : float
        Vertical field of view in degrees, (0, 180).
    exposure : float
        Exposure in EV applied before tone mapping; 0 leaves radiance as it is.
    """

    position: tuple[float, float, float]
    target: tuple[float, float, float]
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)
    fov_y: float = 40.0
    exposure: float = 0.0

    def view_from_world_rotation(self) -> FloatArray:
        """Return the (3, 3) rotation from world to view space (looks along -z)."""
        return math3d.look_rotation(self.position, self.target, self.up)

    def tan_half_fov(self, aspect: float) -> tuple[float, float]:
        """Return tangents of half the (horizontal, vertical) field of view.

        Parameters
        ----------
        aspect : float
            Width over height of the picture.
        """
        vertical = float(np.tan(np.radians(self.fov_y) / 2.0))
        return vertical * aspect, vertical
