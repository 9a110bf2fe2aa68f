"""Distant light from all directions."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Real
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, IntArray
from ssdo_gl.scene.lights import DirectionalLight
from ssdo_gl.scene.material import Color
from ssdo_gl.scene.numbers import light_numbers
from ssdo_gl.settings.fields import SettingError, shown


@dataclass(frozen=True)
class ConstantEnvironment:
    """The same `radiance` from everywhere."""

    radiance: Color

    def __post_init__(self) -> None:
        object.__setattr__(self, "radiance", light_numbers("radiance", self.radiance))

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

    def __post_init__(self) -> None:
        for name in ("zenith", "horizon", "ground"):
            object.__setattr__(self, name, light_numbers(name, getattr(self, name)))

    def sample(self, direction_ws: FloatArray) -> FloatArray:
        """Return radiance (..., 3) arriving from unit directions (..., 3)."""
        y = direction_ws[..., 1:2]
        zenith, horizon, ground = (np.asarray(c) for c in (self.zenith, self.horizon, self.ground))
        return np.asarray(
            horizon
            + (zenith - horizon) * np.maximum(y, 0.0)
            + (ground - horizon) * np.maximum(-y, 0.0)
        )

    def scaled(self, factor: float) -> GradientEnvironment:
        """Return the same sky, `factor` times as bright."""

        def times(color: Color) -> Color:
            return color[0] * factor, color[1] * factor, color[2] * factor

        return GradientEnvironment(times(self.zenith), times(self.horizon), times(self.ground))


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
    sun : DirectionalLight or None
        What shines in place of the image's own sun, as it stands without a turn.
    """

    image: NDArray[np.float32]
    rotation_y: float = 0.0
    name: str = ""
    sun: DirectionalLight | None = None

    def __post_init__(self) -> None:
        image, turn = self.image, self.rotation_y
        if not (isinstance(image, np.ndarray) and image.ndim == 3 and image.shape[2] == 3):
            text = " ".join(shown(image).split())
            raise SettingError(f"image = {text}: expected an array (height, width, 3)")
        # False for NaN, too.
        if not (image.size and image.min() >= 0.0 and image.max() < np.inf):
            raise SettingError("image: expected finite numbers from 0 on, one texel at least")
        if not (isinstance(turn, Real) and np.isfinite(float(turn))):
            raise SettingError(f"rotation_y = {shown(turn)}: expected degrees")

    def world_image(self) -> FloatArray:
        """Return the image turned into world orientation, (height, width, 3), float64.

        A turn by a fraction of a column shares each texel between two neighbours.
        """
        image = self.image.astype(np.float64)
        # Counter-clockwise from above takes +x (3/4 across) to -z (1/2 across).
        shift = (self.rotation_y / 360.0) % 1.0 * image.shape[1]
        whole = int(np.floor(shift))
        part = shift - whole
        turned = np.roll(image, -whole, axis=1)
        return turned if part == 0.0 else (1.0 - part) * turned + part * np.roll(turned, -1, axis=1)

    def sample(self, direction_ws: FloatArray) -> FloatArray:
        """Return radiance (..., 3) arriving from unit directions (..., 3)."""
        image = self.world_image()
        height, width = image.shape[:2]
        x, y, z = (direction_ws[..., axis] for axis in range(3))
        u = np.arctan2(x, -z) / (2.0 * np.pi) + 0.5
        v = np.arccos(np.clip(y, -1.0, 1.0)) / np.pi
        column = np.clip(np.floor(u * width).astype(np.int64), 0, width - 1)
        row = np.clip(np.floor(v * height).astype(np.int64), 0, height - 1)
        return np.asarray(image[row, column])


Environment = ConstantEnvironment | GradientEnvironment | MapEnvironment
EnvironmentKind = Literal["none", "constant", "gradient", "map"]
# In the order of their numbers in shaders (``ENVIRONMENT_KIND``).
ENVIRONMENT_KINDS: tuple[EnvironmentKind, ...] = get_args(EnvironmentKind)


def kind_of(environment: Environment | None) -> EnvironmentKind:
    """Return what an environment is called."""
    if environment is None:
        return "none"
    if isinstance(environment, ConstantEnvironment):
        return "constant"
    return "gradient" if isinstance(environment, GradientEnvironment) else "map"


def texels(
    height: int, width: int, rows: IntArray | None = None, columns: IntArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return unit vectors (R, C, 3) to texels of a map, some of them or all, and solid angles."""
    rows = np.arange(height) if rows is None else rows
    columns = np.arange(width) if columns is None else columns
    azimuth = 2.0 * np.pi * ((columns + 0.5) / width - 0.5)
    polar = np.pi * (rows[:, None] + 0.5) / height
    y = np.broadcast_to(np.cos(polar), (len(rows), len(columns)))
    directions = np.stack(
        [np.sin(polar) * np.sin(azimuth), y, -np.sin(polar) * np.cos(azimuth)], -1
    )
    edges = np.cos(np.pi * rows / height) - np.cos(np.pi * (rows + 1) / height)
    return directions, np.broadcast_to(edges[:, None] * (2.0 * np.pi / width), y.shape)
