"""The [[light]] tables."""

from __future__ import annotations

from typing import cast

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.builder import SceneBuilder
from ssdo_gl.scene.formats.toml.motions import MOTION_TABLE, read_motion
from ssdo_gl.scene.formats.toml.table import Table
from ssdo_gl.scene.light import (
    DirectionalLight,
    PointLight,
    RectangleLight,
    Shadow,
    SpotLight,
    Vector,
)
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.mesh import SceneObject
from ssdo_gl.scene.shapes import quad

SHADOWS = ("map", "ssdo", "none")
_COMMON = ("kind", "name", "shadow", MOTION_TABLE)
_KEYS: dict[str, tuple[str, ...]] = {
    "point": ("position", "intensity"),
    "spot": ("position", "direction", "intensity", "inner_angle", "outer_angle"),
    "directional": ("direction", "irradiance"),
    "area": ("corner", "edge_u", "edge_v", "radiance", "visible", "two_sided"),
}
# The sine of the angle between two edges below which the float64 cross product is
# rounding noise rather than an area.
FLAT_SINE = 1e-12


def read_light(table: Table, builder: SceneBuilder) -> None:
    """Add the light, and the rectangle that shows it if it is a visible area."""
    kind = table.text("kind", choices=tuple(_KEYS))
    table.allow(*_COMMON, *_KEYS[kind])
    shadow = cast(Shadow, table.text("shadow", "map", SHADOWS))
    name = table.text("name", "")
    if kind == "area":
        _read_area(table, shadow, name, builder)
    elif kind == "directional":
        direction = table.direction("direction")
        motion = read_motion(table, (0.0, 0.0, 0.0))
        irradiance = table.color("irradiance")
        builder.lights.append(DirectionalLight(unit(direction), irradiance, shadow, name, motion))
    else:
        position = table.vector("position")
        motion = read_motion(table, position)
        intensity = table.color("intensity")
        if kind == "point":
            builder.lights.append(PointLight(position, intensity, shadow, name, motion))
            return
        outer = table.number("outer_angle", 45.0, low=0.0, high=90.0, open_ends=True)
        inner = table.number("inner_angle", 0.0, low=0.0, high=90.0)
        if inner >= outer:
            table.fail("inner_angle", f"must be less than outer_angle ({outer:g} degrees)")
        direction = unit(table.direction("direction"))
        builder.lights.append(
            SpotLight(position, direction, intensity, inner, outer, shadow, name, motion)
        )


def _read_area(table: Table, shadow: Shadow, name: str, builder: SceneBuilder) -> None:
    corner, edge_u, edge_v = read_parallelogram(table)
    middle = np.array(corner) + 0.5 * (np.array(edge_u) + np.array(edge_v))
    motion = read_motion(table, as_vector(middle))
    light = RectangleLight(
        corner,
        edge_u,
        edge_v,
        table.color("radiance"),
        shadow,
        table.boolean("visible", True),
        table.boolean("two_sided", False),
        name,
        motion,
    )
    builder.lights.append(light)
    if not light.visible:
        return
    material = Material(
        name=name or "light",
        albedo=(0.0, 0.0, 0.0),
        emission=light.radiance,
        two_sided_emission=light.two_sided,
    )
    builder.add(
        SceneObject(
            mesh=builder.mesh("quad", quad),
            material=builder.material(material),
            world_from_object=parallelogram_matrix(corner, edge_u, edge_v)[None],
            motion=motion,
            light=len(builder.lights) - 1,
            name=name or "light",
        )
    )


def read_parallelogram(table: Table) -> tuple[Vector, Vector, Vector]:
    """Return corner, edge_u and edge_v, which must span an area."""
    corner = table.vector("corner")
    edge_u, edge_v = table.direction("edge_u"), table.direction("edge_v")
    sine = np.linalg.norm(np.cross(math3d.normalized(edge_u), math3d.normalized(edge_v)))
    if sine < FLAT_SINE:
        table.fail("edge_v", "must not be parallel to edge_u: the area would be zero")
    return corner, edge_u, edge_v


def parallelogram_matrix(corner: Vector, edge_u: Vector, edge_v: Vector) -> FloatArray:
    """Return the (4, 4) matrix that puts the unit quad onto a parallelogram."""
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 3] = edge_u, edge_v, corner
    # Any third column on the front side will do for a flat shape; one as long as
    # the edges keeps the matrix well conditioned at every scale.
    normal = math3d.normalized(np.cross(math3d.normalized(edge_u), math3d.normalized(edge_v)))
    matrix[:3, 2] = normal * np.sqrt(np.linalg.norm(edge_u) * np.linalg.norm(edge_v))
    return matrix


def as_vector(array: FloatArray) -> Vector:
    """Return three floats as a tuple."""
    x, y, z = (float(value) for value in array)
    return x, y, z


def unit(direction: Vector) -> Vector:
    """Return the direction with length one."""
    return as_vector(math3d.normalized(direction))
