"""Changes what the surfaces of a scene are made of, and says what a point lies on. Pure."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray, Vector
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

# Factors of a material that can be changed, all of [0, 1], and its other numbers.
SHARES = ("metallic", "roughness", "specular", "alpha")
EDITED = ("albedo", "emission", *SHARES, "ior")


def edited_material(original: Material, values: Mapping[str, Any]) -> Material:
    """Return `original` with other `values` of `EDITED`.

    One whose alpha comes to be below 1 lets what lies behind show through.
    """
    changed = dataclasses.replace(original, **values)
    is_clearer = changed.alpha != original.alpha and changed.alpha < 1.0
    return dataclasses.replace(changed, blends=original.blends or is_clearer)


def with_edited(scene: Scene, index: int, material: Material) -> Scene:
    """Return the scene with another material in the place of one."""
    materials = list(scene.materials)
    materials[index] = material
    return dataclasses.replace(scene, materials=tuple(materials))


def material_name(scene: Scene, index: int) -> str:
    """Return what a material is called, or the first object of it, and its number from 1."""
    users = (item.name for item in scene.objects if item.material == index)
    name = scene.materials[index].name or next(users, "")
    return f"{name or 'material'} {index + 1}"


def shows_light(scene: Scene, index: int) -> bool:
    """Return whether a material is that of a light's body: its emission is the light's."""
    return any(item.material == index and item.light is not None for item in scene.objects)


def material_at(scene: Scene, point: Vector) -> int | None:
    """Return the material of the surface that a world-space point lies on, or nearest to.

    None if the point is not within a hundredth of the scene of any triangle's box.
    """
    low, high = scene.bounds()
    reach = 0.01 * float(np.linalg.norm(high - low))
    nearest, found = reach, None
    for item in scene.objects:
        mesh = scene.meshes[item.mesh]
        for matrix in item.world_from_object:
            corners = math3d.transform_points(matrix, mesh.positions)
            near = [(corners.min(axis=0) - point).max(), (point - corners.max(axis=0)).max()]
            if max(near) > nearest:
                continue
            distance = _distance(corners[mesh.triangles], np.asarray(point), nearest)
            if distance < nearest:
                nearest, found = distance, item.material
    return found


def _distance(triangles: FloatArray, point: FloatArray, reach: float) -> float:
    """Return how far the nearest of (N, 3, 3) triangles is; infinity beyond `reach`.

    Beside a corner, that is how far the point is from the lines through its edges.
    """
    low, high = triangles.min(axis=1) - reach, triangles.max(axis=1) + reach
    a, b, c = np.moveaxis(triangles[((low <= point) & (point <= high)).all(axis=1)], 1, 0)
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    a, b, c, normal = (array[length[:, 0] > 0.0] for array in (a, b, c, normal))
    if not len(a):
        return float("inf")
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    beside = np.zeros(len(a))
    for start, end in ((a, b), (b, c), (c, a)):
        outward = np.cross(end - start, normal)
        outward /= np.linalg.norm(outward, axis=1, keepdims=True)
        beside = np.maximum(beside, ((point - start) * outward).sum(axis=1))
    above = ((point - a) * normal).sum(axis=1)
    return float(np.hypot(above, beside).min())
