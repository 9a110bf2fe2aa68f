"""Many small meshes of materials that differ in base colour alone become few large ones.

Each object of a mesh and material of its own costs a draw call in every pass, some
milliseconds in all; a model with thousands of colours would take minutes.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.geometry.topology import placed, unit_tangents
from ssdo_gl.scene.material import Material

# Below it every object keeps its mesh, whose instances and bounds serve culling.
MIN_OBJECTS = 500
# A batch is culled as a whole: it should hold no more than a good part of a scene.
MAX_TRIANGLES = 100_000


def batched(
    meshes: Sequence[Mesh], materials: Sequence[Material], objects: Sequence[SceneObject]
) -> tuple[list[Mesh], list[Material], list[SceneObject]]:
    """Return a scene's parts with still, single objects joined where there are many.

    The albedo of each becomes the colour of its vertices: the picture stays.
    """
    kept: list[SceneObject] = []
    groups: dict[tuple[object, ...], list[SceneObject]] = {}
    for item in objects:
        key = _key(meshes[item.mesh], materials[item.material], item)
        if key is None:
            kept.append(item)
        else:
            groups.setdefault(key, []).append(item)
    if not any(len(members) >= MIN_OBJECTS for members in groups.values()):
        return list(meshes), list(materials), list(objects)
    new_meshes, new_materials = list(meshes), list(materials)
    for members in groups.values():
        if len(members) < MIN_OBJECTS:
            kept += members
            continue
        material = materials[members[0].material]
        new_materials.append(_common(material, "joined"))
        for batch in _batches(meshes, members):
            new_meshes.append(_joined(meshes, materials, batch))
            index = len(new_meshes) - 1
            kept.append(SceneObject(index, len(new_materials) - 1, name="joined"))
    return _without_unused(new_meshes, new_materials, kept)


def _batches(meshes: Sequence[Mesh], members: Sequence[SceneObject]) -> list[list[SceneObject]]:
    """Return `members` in lists of at most MAX_TRIANGLES, or of one."""
    batches: list[list[SceneObject]] = []
    count = MAX_TRIANGLES
    for item in members:
        size = len(meshes[item.mesh].triangles)
        if count + size > MAX_TRIANGLES:
            batches.append([])
            count = 0
        batches[-1].append(item)
        count += size
    return batches


def _key(mesh: Mesh, material: Material, item: SceneObject) -> tuple[object, ...] | None:
    """Return what objects of one batch have in common, or None for one that stays alone."""
    if (
        item.motion is not None
        or mesh.pose is not None
        or item.light is not None
        or len(item.world_from_object) != 1
    ):
        return None
    common = _common(material, "")
    arrays = (mesh.normals, mesh.uvs, mesh.second_uvs, mesh.tangents)
    fields = (getattr(common, field.name) for field in dataclasses.fields(common))
    return *(array is not None for array in arrays), mesh.closed, *fields


def _common(material: Material, name: str) -> Material:
    """Return `material` without what becomes the colour of vertices."""
    # An image that is cut out where its alpha is low depends on the factor of that.
    cuts_image = material.alpha_cutoff is not None and material.albedo_texture is not None
    alpha = material.alpha if cuts_image else 1.0
    return dataclasses.replace(material, name=name, albedo=(1.0, 1.0, 1.0), alpha=alpha)


def _joined(
    meshes: Sequence[Mesh], materials: Sequence[Material], members: Sequence[SceneObject]
) -> Mesh:
    """Return one mesh, in world space, of meshes that agree in what they have."""
    parts = [meshes[item.mesh] for item in members]
    vertices = [
        _vertices(part, materials[item.material], item.world_from_object[0])
        for part, item in zip(parts, members, strict=True)
    ]
    arrays: dict[str, Any] = {
        name: np.concatenate([arrays[name] for arrays in vertices]) for name in vertices[0]
    }
    first = np.cumsum([0] + [len(part.positions) for part in parts[:-1]])
    return Mesh(
        triangles=np.concatenate(
            [part.triangles + start for part, start in zip(parts, first, strict=True)]
        ),
        closed=parts[0].closed,
        name="joined",
        **arrays,
    )


def _vertices(mesh: Mesh, material: Material, matrix: FloatArray) -> dict[str, Any]:
    """Return what vertices of a mesh have, in world space; the albedo is in their colours."""
    linear = matrix[:3, :3]
    alpha = 1.0 if _common(material, "").alpha != 1.0 else material.alpha
    colors = np.ones((len(mesh.positions), 4)) if mesh.colors is None else mesh.colors
    found = {"uvs": mesh.uvs, "second_uvs": mesh.second_uvs}
    found["positions"] = placed(mesh.positions, matrix[None])[0]
    found["colors"] = colors * [*material.albedo, alpha]
    if mesh.normals is not None:
        # Normals turn with the cofactors; instances of a batch are not mirrored.
        cofactor = [np.cross(linear[(i + 1) % 3], linear[(i + 2) % 3]) for i in range(3)]
        normals = mesh.normals @ np.stack(cofactor).T
        found["normals"] = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    if mesh.tangents is not None:
        directions = mesh.tangents[:, :3] @ linear.T
        found["tangents"] = unit_tangents(np.column_stack([directions, mesh.tangents[:, 3]]))
    return {name: array for name, array in found.items() if array is not None}


def _without_unused(
    meshes: list[Mesh], materials: list[Material], objects: list[SceneObject]
) -> tuple[list[Mesh], list[Material], list[SceneObject]]:
    used_meshes = sorted({item.mesh for item in objects})
    used_materials = sorted({item.material for item in objects})
    mesh_of = {old: new for new, old in enumerate(used_meshes)}
    material_of = {old: new for new, old in enumerate(used_materials)}
    return (
        [meshes[i] for i in used_meshes],
        [materials[i] for i in used_materials],
        [
            dataclasses.replace(o, mesh=mesh_of[o.mesh], material=material_of[o.material])
            for o in objects
        ],
    )
