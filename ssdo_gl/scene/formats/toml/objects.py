"""The [[object]] tables: shape and the matrix that places it, material, repetition, motion."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Hashable
from functools import partial
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray, vector
from ssdo_gl.scene.builder import SceneBuilder
from ssdo_gl.scene.files import Table
from ssdo_gl.scene.formats import read_model
from ssdo_gl.scene.formats.toml.materials import file_beside
from ssdo_gl.scene.formats.toml.scene_tables import (
    MOTION_TABLE,
    SHADOWS,
    read_motion,
    spins_in_place,
)
from ssdo_gl.scene.geometry import (
    MAX_INSTANCES,
    SEGMENTS,
    Mesh,
    SceneObject,
    box,
    cone,
    cylinder,
    parallelogram_matrix,
    quad,
    sphere,
    torus,
)
from ssdo_gl.scene.lights import Shadow
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.motion import Carried, Motion
from ssdo_gl.wording import printable, suggestion

_COMMON = ("shape", "name", "material", "transform", "repeat", MOTION_TABLE, "shadow")
# Each of them is an object of its own.
MAX_SPINNING = 10_000
NORMALS = ("smooth", "flat", "file")
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
SHAPES = (*FORM_KEYS, "mesh")


def read_object(
    table: Table, file: Path | None, material_of_name: dict[str, int], builder: SceneBuilder
) -> None:
    """Add what one [[object]] table describes."""
    shape = table.text("shape", choices=SHAPES)
    keys = ("path", "normals") if shape == "mesh" else FORM_KEYS[shape]
    table.allow(*_COMMON, *keys)
    material = _material(table, material_of_name)
    name = table.text("name", shape)
    if shape == "mesh":
        parts = _model_parts(table, file, material, builder)
    else:
        key, make, matrix = read_form(shape, table)
        if material is None:
            material = _default_material(builder)
        parts = [SceneObject(builder.mesh(key, make), material, matrix[None], name=name)]
    matrices = _instances(table)
    shadow = cast(Shadow, table.text("shadow", "map", SHADOWS))
    # What has a motion of its own needs one for each copy.
    if any(part.motion is not None for part in parts):
        _check_copies(table, len(matrices), "copies of a model that moves")
        groups = [matrix[None] for matrix in matrices]
    else:
        groups = [matrices]
    for group in groups:
        _add(table, [_placed(part, group) for part in parts], len(group), shadow, builder)


def _placed(part: SceneObject, matrices: FloatArray) -> SceneObject:
    """Return an object where each of the matrices (N, 4, 4) places it, with its own motion."""
    placed = (matrices[:, None] @ part.world_from_object).reshape(-1, 4, 4)
    motion = None if part.motion is None else Carried(part.motion, matrices[0])
    return dataclasses.replace(part, world_from_object=placed, motion=motion)


def _moved(part: SceneObject, motion: Motion | None) -> SceneObject:
    """Return an object that moves as its table says, besides its motion of its own."""
    if isinstance(part.motion, Carried):
        return dataclasses.replace(part, motion=dataclasses.replace(part.motion, outer=motion))
    return dataclasses.replace(part, motion=motion)


def _check_copies(table: Table, count: int, what: str) -> None:
    if count > MAX_SPINNING:
        table.fail("repeat", f"{count} {what}: at most {MAX_SPINNING}")


def _add(
    table: Table, parts: list[SceneObject], count: int, shadow: Shadow, builder: SceneBuilder
) -> None:
    """Add the parts with their motion; each copy that spins does so about itself."""
    if not spins_in_place(table):
        motion = read_motion(table, (0.0, 0.0, 0.0))
        for part in parts:
            builder.add(_moved(part, motion), shadow)
        return
    _check_copies(table, count, "copies that spin, each about itself")
    for copy in range(count):
        copies = []
        for part in parts:
            per_copy = len(part.world_from_object) // count
            rows = slice(copy * per_copy, (copy + 1) * per_copy)
            copies.append(dataclasses.replace(part, world_from_object=part.world_from_object[rows]))
        motion = read_motion(table, vector(_middle(copies, builder)))
        for part in copies:
            builder.add(_moved(part, motion), shadow)


def _middle(parts: list[SceneObject], builder: SceneBuilder) -> FloatArray:
    """Return the middle of the parts' bounding box in world space."""
    points = []
    for part in parts:
        low, high = builder.meshes[part.mesh].bounds()
        for matrix in part.world_from_object:
            middle = math3d.transform_points(matrix, 0.5 * (low + high))
            reach = np.abs(matrix[:3, :3]) @ (0.5 * (high - low))
            points += [middle - reach, middle + reach]
    return np.asarray(0.5 * (np.min(points, axis=0) + np.max(points, axis=0)))


def _material(table: Table, material_of_name: dict[str, int]) -> int | None:
    if "material" not in table:
        return None
    name = table.text("material")
    if name not in material_of_name:
        hint = suggestion(name, material_of_name)
        table.fail("material", f"no [materials.{printable(name[:40])}] in this file{hint}")
    return material_of_name[name]


def _default_material(builder: SceneBuilder) -> int:
    for index, material in enumerate(builder.materials):
        if material.name == "default":
            return index
    return builder.material(Material(name="default"))


def _model_parts(
    table: Table, file: Path | None, material: int | None, builder: SceneBuilder
) -> list[SceneObject]:
    """Return the objects of a model file, with `material` in place of its own."""
    path = file_beside(table, "path", file)
    normals = table.text("normals", choices=NORMALS) if "normals" in table else None
    key = ("model", str(path), material, normals)
    known = builder.models.get(key)
    if known is None:
        known = read_model(path, table.where("path"), normals).add_to(builder, material)
        builder.models[key] = known
    return known


def _instances(table: Table) -> FloatArray:
    """Return (N, 4, 4): the transform, repeated in world space."""
    transform = np.eye(4)
    inside = table.table("transform")
    if inside is not None:
        inside.allow("translate", "rotate", "scale")
        transform = math3d.transform_matrix(
            inside.vector("translate", (0.0, 0.0, 0.0)),
            inside.vector("rotate", (0.0, 0.0, 0.0)),
            _scale(inside),
        )
    repeat = table.table("repeat")
    if repeat is None:
        return transform[None]
    repeat.allow("count", "step")
    grid = _grid(repeat)
    matrices = np.repeat(transform[None], len(grid), axis=0)
    matrices[:, :3, 3] += grid * repeat.numbers("step", 3)
    return matrices


def _grid(repeat: Table) -> NDArray[np.int64]:
    """Return (N, 3) multiples of `step`: a grid for three counts, a row for one."""
    along_row = not isinstance(repeat.data.get("count"), list)
    counts = np.array([repeat.number("count")]) if along_row else repeat.numbers("count", 3)
    if not all(n >= 1 and n == int(n) for n in counts) or np.prod(counts) > MAX_INSTANCES:
        repeat.fail(
            "count",
            f"expected one or three whole numbers >= 1, at most {MAX_INSTANCES} copies in all",
        )
    if along_row:
        return np.repeat(np.arange(int(counts[0]))[:, None], 3, axis=1)
    axes = [np.arange(int(n)) for n in counts]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def _scale(table: Table) -> FloatArray:
    """Return three scale factors; negative ones mirror, zero is refused."""
    if "scale" not in table:
        return np.ones(3)
    if isinstance(table.data["scale"], list):
        factors = table.numbers("scale", 3)
    else:
        factors = np.full(3, table.number("scale"))
    if not np.all(factors):
        table.fail("scale", "must not be zero")
    return factors


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
