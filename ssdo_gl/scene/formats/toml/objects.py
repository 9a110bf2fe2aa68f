"""The [[object]] tables: shape, material, transform, repetition, motion."""

from __future__ import annotations

import dataclasses
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
from ssdo_gl.scene.formats.toml.placed_shapes import FORM_KEYS, read_form
from ssdo_gl.scene.formats.toml.scene_tables import (
    MOTION_TABLE,
    SHADOWS,
    read_motion,
    spins_in_place,
)
from ssdo_gl.scene.geometry import MAX_INSTANCES, SceneObject
from ssdo_gl.scene.lights import Shadow
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.motion import Carried, Motion
from ssdo_gl.wording import printable, suggestion

_COMMON = ("shape", "name", "material", "transform", "repeat", MOTION_TABLE, "shadow")
# Each of them is an object of its own.
MAX_SPINNING = 10_000
NORMALS = ("smooth", "flat", "file")
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
