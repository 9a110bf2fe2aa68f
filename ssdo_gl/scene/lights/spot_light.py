"""Light from a point into a cone."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray, Vector, vector
from ssdo_gl.scene.files import Table
from ssdo_gl.scene.lights.base import BoundsOf, ShaderRow, ShadowView
from ssdo_gl.scene.lights.point_light import PunctualLight
from ssdo_gl.scene.material import Color
from ssdo_gl.scene.numbers import hold_numbers
from ssdo_gl.settings.fields import SettingError

# A wider cone in one picture would waste most texels on its rim: at 60 degrees the rim
# has 1/4 of the centre's density, and the five faces of a half cube do better beyond.
WIDEST_SINGLE_FACE = 60.0
# Of files, degrees: a narrower cone would be a few hundred roundings of float32 wide.
NARROWEST = 0.01
# A ramp that takes less of the cone is a step: float32 would not resolve it.
NARROWEST_RAMP = 1e-6


@dataclass(frozen=True)
class SpotLight(PunctualLight):
    """A point light inside a cone around `direction` (world space, unit length).

    `intensity` (W/sr) holds within `inner_angle`, falls smoothly to zero at
    `outer_angle` (half-angles in degrees, 0 <= inner < outer < 90) by glTF's
    KHR_lights_punctual rule: the squared, clamped linear ramp in the cosine.
    """

    kind = "spot"
    gltf_type = "spot"
    direction_fields = ("direction",)

    position: Vector
    direction: Vector
    intensity: Color
    inner_angle: float = 0.0
    outer_angle: float = 45.0

    def __post_init__(self) -> None:
        super().__post_init__()
        hold_numbers(self, "inner_angle", "outer_angle")
        if not 0.0 <= self.inner_angle <= self.outer_angle < 90.0:
            raise SettingError(
                f"inner_angle = {self.inner_angle!r}, outer_angle = {self.outer_angle!r}: expected "
                "0 <= inner <= outer < 90 degrees"
            )

    @classmethod
    def from_table(cls, table: Table, **common: Any) -> Self:
        position, intensity = table.vector("position"), table.color("intensity")
        outer = table.number("outer_angle", 45.0, low=0.0, high=90.0, open_ends=True)
        inner = table.number("inner_angle", 0.0, low=0.0, high=90.0)
        if inner >= outer:
            table.fail("inner_angle", f"must be less than outer_angle ({outer:g} degrees)")
        if outer < NARROWEST:
            table.fail("outer_angle", f"must be at least {NARROWEST:g} degrees")
        direction = vector(math3d.normalized(table.direction("direction")))
        return cls(position, direction, intensity, inner, outer, **common)

    @classmethod
    def from_gltf(
        cls, light: Mapping[str, Any], place: Vector, direction: Vector, color: Color, name: str
    ) -> Self:
        spot = light.get("spot", {})
        outer = float(np.degrees(spot.get("outerConeAngle", np.pi / 4.0)))
        inner = float(np.degrees(spot.get("innerConeAngle", 0.0)))
        if not (math.isfinite(outer) and math.isfinite(inner)):
            raise ValueError("the angles of a spot must be finite")
        # The widest cone that a spot's shadow map can hold; inner must stay below.
        outer = min(max(outer, NARROWEST), 89.9)
        inner = min(max(inner, 0.0), 0.999 * outer)
        return cls(place, direction, color, inner, outer, name=name)

    def axes(self) -> FloatArray:
        """Return a frame around the direction."""
        return math3d.frame_from_z(self.direction).T

    def shader_row(self) -> ShaderRow:
        """Return the position, the unit direction and the cone.

        Its numbers: 1 - cosine of the outer angle, 1 / (cosine inner - cosine outer). Both
        by half angles, because cosines of narrow cones are all 1 but for rounding.
        """
        inner, outer = 0.5 * math.radians(self.inner_angle), 0.5 * math.radians(self.outer_angle)
        width = 2.0 * math.sin(outer) ** 2
        ramp = 2.0 * math.sin(outer + inner) * math.sin(outer - inner)
        slope = 1.0 / max(ramp, NARROWEST_RAMP * width, 1e-30)
        return ShaderRow(self.source, self.axes()[2], numbers=(width, slope))

    def share(self) -> float:
        """Return the cone's part of all directions."""
        return 0.5 * (1.0 - math.cos(math.radians(self.outer_angle)))

    @property
    def map_faces(self) -> int:
        """One, or the half cube."""
        return 1 if self.outer_angle <= WIDEST_SINGLE_FACE else 5

    def shadow_view(self, bounds_of: BoundsOf, parts_per_side: int) -> ShadowView:
        """Return the cone, or right angles around the position."""
        tangent = math.tan(math.radians(self.outer_angle)) if self.map_faces == 1 else 1.0
        return ShadowView(self.source, (tangent, tangent))

    def is_lit(self, direction: FloatArray) -> FloatArray:
        """Return 1 within the outer angle."""
        aim = direction @ math3d.normalized(self.direction)
        return np.asarray(aim > np.cos(np.radians(self.outer_angle)), np.float64)
