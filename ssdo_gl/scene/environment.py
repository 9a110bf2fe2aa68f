"""Distant light from all directions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.material import Color


@dataclass(frozen=True)
class ConstantEnvironment:
    """The same `radiance` from everywhere."""

    radiance: Color

    def sample(self, direction_ws: FloatArray) -> FloatArray:
        """Return radiance (..., 3) arriving from unit directions (..., 3)."""
        return np.broadcast_to(np.asarray(self.radiance), direction_ws.shape).copy()


@dataclass(frozen=True)
class GradientEnvironment:
    """Radiance that varies with elevation only, up = +y.

    With y the upward component of the direction: horizon + (zenith - horizon) y
    above and horizon + (ground - horizon) |y| below.
    """

    zenith: Color
    horizon: Color
    ground: Color

    def sample(self, direction_ws: FloatArray) -> FloatArray:
        """Return radiance (..., 3) arriving from unit directions (..., 3)."""
        y = direction_ws[..., 1:2]
        zenith, horizon, ground = (
            np.asarray(c) for c in (self.zenith, self.horizon, self.ground)
        )
        return np.asarray(
            horizon
            + (zenith - horizon) * np.maximum(y, 0.0)
            + (ground - horizon) * np.maximum(-y, 0.0)
        )


@dataclass(frozen=True, eq=False)
class MapEnvironment:
    """A lat-long image; texels are constant patches (nearest lookup).

    Attributes
    ----------
    image : ndarray, shape (height, width, 3), float32
        Finite, >= 0. Row 0 is +y. With direction d: u = atan2(d.x, -d.z) / (2 pi)
        + 1/2 (so -z is the middle column, +x a quarter to the right of it),
        v = acos(d.y) / pi.
    rotation_y : float
        Degrees by which the image is turned about +y (counter-clockwise from above).
    """

    image: NDArray[np.float32]
    rotation_y: float = 0.0
    name: str = ""


Environment = ConstantEnvironment | GradientEnvironment | MapEnvironment
