"""Primitive shapes of a scene file: which unit mesh, and the matrix that places it."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import partial

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.files import Table
from ssdo_gl.scene.geometry import (
    SEGMENTS,
    Mesh,
    box,
    cone,
    cylinder,
    parallelogram_matrix,
    quad,
    sphere,
    torus,
)

# Keys that each shape takes besides those of every object.
FORM_KEYS: dict[str, tuple[str, ...]] = {
    "box": ("min", "max"),
    "quad": ("corner", "edge_u", "edge_v"),
    "plane": ("point", "normal", "size"),
    "sphere": ("center", "radius", "segments", "bump"),
    "cylinder": ("base", "top", "radius", "segments"),
    "cone": ("base", "top", "radius", "segments"),
    "torus": ("center", "axis", "radius", "thickness", "segments", "arc"),
}
MAX_SEGMENTS = 2048
# Of its radius: below, rounding leaves a torus no surface.
_THINNEST = 1e-12

PlacedShape = tuple[Hashable, Callable[[], Mesh], FloatArray]


def read_form(shape: str, table: Table) -> PlacedShape:
    """Return the key and maker of the unit mesh, and its (4, 4) world matrix."""
    return _READERS[shape](table)


def _box(table: Table) -> PlacedShape:
    low, high = table.numbers("min", 3), table.numbers("max", 3)
    if not np.all(high > low):
        table.fail("max", f"must exceed min = {low.tolist()} on every axis")
    matrix = math3d.translation(0.5 * (low + high)) @ math3d.scaling(high - low)
    return "box", box, matrix


def _quad(table: Table) -> PlacedShape:
    return "quad", quad, parallelogram_matrix(*table.parallelogram())


def _plane(table: Table) -> PlacedShape:
    point = table.numbers("point", 3)
    frame = math3d.frame_from_z(table.direction("normal"))
    if isinstance(table.data.get("size"), list):
        sides = table.numbers("size", 2)
        if not np.all(sides > 0.0):
            table.fail("size", "expected a number or two greater than 0")
    else:
        sides = np.full(2, table.number("size", low=0.0, open_ends=True))
    edge_u, edge_v = frame[:, 0] * sides[0], frame[:, 1] * sides[1]
    corner = point - 0.5 * (edge_u + edge_v)
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 3] = edge_u, edge_v, corner
    matrix[:3, 2] = frame[:, 2] * np.sqrt(sides[0] * sides[1])
    return "quad", quad, matrix


def _sphere(table: Table) -> PlacedShape:
    radius = _radius(table)
    segments = _segments(table)
    amplitude, frequency = 0.0, 8.0
    bump = table.table("bump")
    if bump is not None:
        bump.allow("amplitude", "frequency")
        amplitude = bump.number("amplitude", 0.05, low=0.0, high=0.9)
        frequency = bump.number("frequency", 8.0, low=0.0, high=1000.0)
    matrix = math3d.translation(table.vector("center", (0.0, 0.0, 0.0))) @ math3d.scaling(radius)
    make = partial(sphere, segments, amplitude, frequency)
    return ("sphere", segments, amplitude, frequency), make, matrix


def _cylinder(table: Table) -> PlacedShape:
    segments = _segments(table)
    return ("cylinder", segments), partial(cylinder, segments), _axial(table)


def _cone(table: Table) -> PlacedShape:
    segments = _segments(table)
    return ("cone", segments), partial(cone, segments), _axial(table)


def _axial(table: Table) -> FloatArray:
    """Return the matrix that puts the unit z axis onto base -> top."""
    base, top = table.numbers("base", 3), table.numbers("top", 3)
    axis = top - base
    if not np.any(axis):
        table.fail("top", "must not coincide with base")
    radius = _radius(table)
    frame = math3d.frame_from_z(axis)
    height = float(np.linalg.norm(axis))
    matrix = np.eye(4)
    matrix[:3, :3] = frame * np.array([radius, radius, height])
    matrix[:3, 3] = base
    return matrix


def _torus(table: Table) -> PlacedShape:
    radius = _radius(table)
    thickness = table.number("thickness", low=_THINNEST * radius, high=2.0 * radius, open_ends=True)
    segments = _segments(table)
    axis = table.direction("axis", (0.0, 1.0, 0.0))
    frame = math3d.frame_from_z(axis)
    degrees = 360.0
    arc = table.table("arc")
    if arc is not None:
        arc.allow("from", "degrees")
        degrees = arc.number("degrees", low=0.0, high=360.0, open_ends=True)
        start = arc.numbers("from", 3)
        across = np.cross(frame[:, 2], start)
        if np.linalg.norm(across) <= 1e-6 * np.linalg.norm(start):
            arc.fail("from", "must be a direction that is not parallel to axis")
        across = math3d.normalized(across)
        frame = np.stack([np.cross(across, frame[:, 2]), across, frame[:, 2]], axis=1)
    matrix = np.eye(4)
    matrix[:3, :3] = frame * radius
    matrix[:3, 3] = table.vector("center", (0.0, 0.0, 0.0))
    tube = 0.5 * thickness / radius
    make = partial(torus, tube, degrees, segments)
    return ("torus", tube, degrees, segments), make, matrix


def _radius(table: Table) -> float:
    return table.number("radius", low=0.0, open_ends=True)


def _segments(table: Table) -> int:
    return table.integer("segments", SEGMENTS, 3, MAX_SEGMENTS)


_READERS: dict[str, Callable[[Table], PlacedShape]] = {
    "box": _box,
    "quad": _quad,
    "plane": _plane,
    "sphere": _sphere,
    "cylinder": _cylinder,
    "cone": _cone,
    "torus": _torus,
}
