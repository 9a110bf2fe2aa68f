"""Light from a point."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from ssdo_gl.math3d import FloatArray, Vector
from ssdo_gl.scene.files import Table
from ssdo_gl.scene.lights.base import BoundsOf, Emitter, Form, Light, ShaderRow, ShadowView
from ssdo_gl.scene.material import Color


@dataclass(frozen=True, kw_only=True)
class PunctualLight(Light):
    """What all lights without size have in common: `position` and `intensity` (W/sr)."""

    form = Form.POINT
    emitted_field = "intensity"
    emitted_unit = "W/sr"
    point_fields = ("position",)

    @property
    def source(self) -> FloatArray:
        """The position, shape (3,)."""
        return np.asarray(self.place, np.float64)

    def axes(self) -> FloatArray:
        return np.eye(3)

    def shader_row(self) -> ShaderRow:
        return ShaderRow(self.source)

    def emitter(self, centre: FloatArray, unit: float) -> Emitter:
        """Return the shader's row; intensity / distance^2 holds in any unit."""
        row = self.shader_row()
        intensity = np.asarray(self.emitted) / unit**2
        return Emitter(
            place=(self.source - centre) / unit,
            axis=row.axis,
            second_axis=np.array([*row.numbers, 0.0]),
            number=0.0,
            emitted=intensity,
            power=4.0 * math.pi * float(np.mean(intensity)) * self.share(),
        )

    def share(self) -> float:
        """Return which part of all directions it shines into."""
        return 1.0

    @property
    def map_faces(self) -> int:
        """All six."""
        return 6

    def shadow_view(self, bounds_of: BoundsOf, parts_per_side: int) -> ShadowView:
        """Return right angles around the position."""
        return ShadowView(self.source)

    def outline(self) -> FloatArray:
        return self.source[None]

    def sender_radiance(self, nearest: float) -> float:
        """Return that of a surface at `nearest`; 0 if that is 0."""
        return self.power / (math.pi * nearest * nearest) if nearest > 0.0 else 0.0

    def irradiance_at(self, points: FloatArray, normals: FloatArray) -> FloatArray:
        """Return intensity * cosine / distance^2."""
        offset = self.source - points
        squared = np.maximum((offset**2).sum(axis=1), 1e-12 * float(np.ptp(points) ** 2) or 1.0)
        direction = offset / np.sqrt(squared)[:, None]
        cosine = (direction * normals).sum(axis=1) * self.is_lit(-direction)
        return np.asarray(cosine / squared * np.mean(self.emitted))

    def is_lit(self, direction: FloatArray) -> FloatArray:
        """Return 1 for unit vectors (N, 3) into which it shines, else 0."""
        return np.ones(len(direction))


@dataclass(frozen=True)
class PointLight(PunctualLight):
    """An isotropic point light; `intensity` in W/sr per colour channel."""

    kind = "point"
    gltf_type = "point"

    position: Vector
    intensity: Color

    @classmethod
    def from_table(cls, table: Table, **common: Any) -> Self:
        return cls(table.vector("position"), table.color("intensity"), **common)

    @classmethod
    def from_gltf(
        cls, light: Any, place: Vector, direction: Vector, color: Color, name: str
    ) -> Self:
        return cls(place, color, name=name)
