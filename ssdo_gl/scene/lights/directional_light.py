"""Light from one direction."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray, Vector, vector
from ssdo_gl.scene.files import Table
from ssdo_gl.scene.lights.base import BoundsOf, Emitter, Form, Light, ShaderRow, ShadowView
from ssdo_gl.scene.material import Color
from ssdo_gl.scene.numbers import hold_numbers
from ssdo_gl.settings.fields import SettingError

# Of files, degrees: what subtends more is a sky, and no light from one direction.
WIDEST = 90.0
# Bounds of a scene along a light, grown by this much so that nothing sits on a border.
BOUNDS_MARGIN = 1e-3


@dataclass(frozen=True)
class DirectionalLight(Light):
    """Parallel light travelling along `direction` (world space, unit length).

    `irradiance` is what a surface facing the light receives, W/m^2. `angle` is the full
    angle in degrees, 0 <= angle < 90, that the light's disk subtends: 0.53 for the sun, 0
    for sharp shadows. The light comes evenly from a disk that stands across `direction`.
    """

    kind = "directional"
    form = Form.PARALLEL
    emitted_field = "irradiance"
    emitted_unit = "W/m²"
    direction_fields = ("direction",)
    gltf_type = "directional"

    direction: Vector
    irradiance: Color
    angle: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        hold_numbers(self, "angle")
        if not 0.0 <= self.angle < WIDEST:
            raise SettingError(
                f"angle = {self.angle!r}: expected degrees from 0 to below {WIDEST:g}"
            )

    @classmethod
    def from_table(cls, table: Table, **common: Any) -> Self:
        direction = vector(math3d.normalized(table.direction("direction")))
        angle = table.number("angle", 0.0, low=0.0, high=WIDEST)
        if angle == WIDEST:
            table.fail("angle", f"must be less than {WIDEST:g} degrees")
        return cls(direction, table.color("irradiance"), angle, **common)

    @classmethod
    def from_gltf(
        cls, light: Any, place: Vector, direction: Vector, color: Color, name: str
    ) -> Self:
        return cls(direction, color, name=name)

    @property
    def spread(self) -> float:
        """The tangent of half the angle."""
        return math.tan(math.radians(0.5 * self.angle))

    def axes(self) -> FloatArray:
        """Return a frame around the direction."""
        return math3d.frame_from_z(self.direction).T

    def shader_row(self) -> ShaderRow:
        """Return the unit vector towards the light and its spread."""
        return ShaderRow(-self.axes()[2], numbers=(self.spread, 0.0))

    def emitter(self, centre: FloatArray, unit: float) -> Emitter:
        """Return the direction and its spread; irradiance is the same in any unit."""
        zero, spread = np.zeros(3), np.array([self.spread, 0.0, 0.0])
        irradiance = np.asarray(self.irradiance)
        toward, power = -math3d.normalized(self.direction), math.pi * float(np.mean(irradiance))
        return Emitter(toward, zero, spread, 0.0, irradiance, power)

    @property
    def map_faces(self) -> int:
        """One."""
        return 1

    def shadow_view(self, bounds_of: BoundsOf, parts_per_side: int) -> ShadowView:
        """Return what encloses the scene."""
        axes = self.axes()
        low, high = bounds_of(axes)
        # A flat scene has no extent along some axis; any is right that is not zero.
        extent = np.maximum(high - low, BOUNDS_MARGIN * float(np.max(high - low)))
        extent = np.where(extent > 0.0, extent, 1.0) * (1.0 + BOUNDS_MARGIN)
        middle = 0.5 * (low + high)
        origin = np.array([middle[0], middle[1], middle[2] - 0.5 * extent[2]]) @ axes
        half = (0.5 * float(extent[0]), 0.5 * float(extent[1]))
        return ShadowView(origin, half, float(extent[2]))

    def outline(self) -> None:
        """Return None: it comes from infinitely far."""
        return

    def sender_radiance(self, nearest: float) -> float:
        """Return that of a surface that faces it."""
        return self.power / math.pi

    def irradiance_at(self, points: FloatArray, normals: FloatArray) -> FloatArray:
        """Return irradiance * cosine."""
        cosine = -(normals @ math3d.normalized(self.direction))
        return np.asarray(cosine * np.mean(self.irradiance))
