"""Light from a parallelogram."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray, Vector, vector
from ssdo_gl.scene.files import Table
from ssdo_gl.scene.geometry import parallelogram_matrix, quad
from ssdo_gl.scene.lights.base import (
    BLACK,
    Body,
    BoundsOf,
    Emitter,
    Form,
    Light,
    ShaderRow,
    ShadowView,
)
from ssdo_gl.scene.material import Color, Material
from ssdo_gl.settings.fields import SettingError

# Tangent of half a face's angle: the shadow of one receiver is looked up in one face, so
# faces reach into their neighbours by the width of a penumbra.
OVERLAP = 1.25


@dataclass(frozen=True)
class RectangleLight(Light):
    """A one-sided parallelogram emitter; emits along edge_u x edge_v.

    Attributes
    ----------
    corner, edge_u, edge_v : Vector
        World space, scene units. The four corners are corner, + edge_u,
        + edge_u + edge_v, + edge_v.
    radiance : Color
        W sr^-1 m^-2.
    visible : bool
        Whether the camera sees it as an emitter and it blocks rays. A visible
        rectangle is drawn by geometry that the Scene carries for it.
    two_sided : bool
        Whether the other side emits too (for emissive meshes that ask for it).
    """

    kind = "rectangle"
    kind_in_files = "area"
    form = Form.AREA
    emitted_field = "radiance"
    emitted_unit = "W/sr/m²"
    point_fields = ("corner",)
    edge_fields = ("edge_u", "edge_v")

    corner: Vector
    edge_u: Vector
    edge_v: Vector
    radiance: Color
    visible: bool = True
    two_sided: bool = False

    @classmethod
    def from_table(cls, table: Table, **common: Any) -> Self:
        corner, edge_u, edge_v = table.parallelogram()
        radiance = table.color("radiance")
        visible, two_sided = table.boolean("visible", True), table.boolean("two_sided", False)
        return cls(corner, edge_u, edge_v, radiance, visible, two_sided, **common)

    def body(self) -> Body | None:
        """Return a black parallelogram that glows, if it is visible."""
        if not self.visible:
            return None
        if not np.cross(self.edge_u, self.edge_v).any():
            raise SettingError(
                f"edge_u = {self.edge_u}, edge_v = {self.edge_v}: expected edges that span an area"
            )
        material = Material(
            name=self.name or "light",
            albedo=BLACK,
            emission=self.radiance,
            two_sided_emission=self.two_sided,
        )
        matrix = parallelogram_matrix(self.corner, self.edge_u, self.edge_v)
        return Body("quad", quad, material, matrix)

    @property
    def place(self) -> Vector:
        return vector(0.5 * np.add(self.edge_u, self.edge_v) + np.asarray(self.corner))

    def moved_to(self, place: Vector) -> Self:
        return self._replace(
            {"corner": vector(np.add(self.corner, np.subtract(place, self.place)))}
        )

    def axes(self) -> FloatArray:
        """Return axes of which x is along the first edge."""
        if not np.any(np.cross(self.edge_u, self.edge_v)):
            return np.eye(3)  # No area, no light: any axes will do.
        x = math3d.normalized(self.edge_u)
        z = math3d.normalized(np.cross(x, math3d.normalized(self.edge_v)))
        return np.stack([x, np.cross(z, x), z])

    def shader_row(self) -> ShaderRow:
        half_u, half_v = 0.5 * np.asarray(self.edge_u), 0.5 * np.asarray(self.edge_v)
        centre = np.asarray(self.corner) + half_u + half_v
        return ShaderRow(centre, half_u, half_v, two_sided=self.two_sided)

    def emitter(self, centre: FloatArray, unit: float) -> Emitter:
        """Return corner, edges and area; radiance is the same in any unit."""
        edge_u, edge_v = np.asarray(self.edge_u) / unit, np.asarray(self.edge_v) / unit
        area = float(np.linalg.norm(np.cross(edge_u, edge_v)))
        power = math.pi * area * float(np.mean(self.radiance)) * (1.0 + self.two_sided)
        corner, radiance = (np.asarray(self.corner) - centre) / unit, np.asarray(self.radiance)
        return Emitter(corner, edge_u, edge_v, area, radiance, power, self.two_sided)

    @property
    def map_faces(self) -> int:
        """The half cube of each side that emits."""
        return 6 if self.two_sided else 5

    def shadow_view(self, bounds_of: BoundsOf, parts_per_side: int) -> ShadowView:
        """Return the centres of equal parts."""
        origin = np.asarray(self.corner) + 0.5 * np.add(self.edge_u, self.edge_v)
        place = (np.arange(parts_per_side) + 0.5) / parts_per_side - 0.5
        v, u = (axis.reshape(-1, 1) for axis in np.meshgrid(place, place, indexing="ij"))
        parts = u * np.asarray(self.edge_u) + v * np.asarray(self.edge_v)
        return ShadowView(origin, (OVERLAP, OVERLAP), parts=parts)

    def outline(self) -> FloatArray:
        corner, u, v = (np.asarray(a, float) for a in (self.corner, self.edge_u, self.edge_v))
        return np.array([corner, corner + u, corner + u + v, corner + v])

    def sender_radiance(self, nearest: float) -> float:
        """Return its radiance: that lights a surface with at most pi times as much."""
        return self.power

    def irradiance_at(self, points: FloatArray, normals: FloatArray) -> FloatArray:
        """Return that of a disk of the same area, about."""
        edges = np.asarray(self.edge_u), np.asarray(self.edge_v)
        area_vector = np.cross(*edges)
        area = float(np.linalg.norm(area_vector))
        offset = np.asarray(self.corner) + 0.5 * (edges[0] + edges[1]) - points
        # Adding the disk of the same area keeps the nearest points finite.
        squared = (offset**2).sum(axis=1) + area / np.pi
        distance = np.sqrt(squared)
        emitted = -(offset @ area_vector) / distance
        emitted = np.abs(emitted) if self.two_sided else np.maximum(emitted, 0.0)
        cosine = (offset * normals).sum(axis=1) / distance
        return np.asarray(emitted * cosine / squared * np.mean(self.radiance))
