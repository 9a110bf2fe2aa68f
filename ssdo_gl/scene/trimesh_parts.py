"""Parts of a scene, and objects of trimesh as such; trimesh itself is not imported."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ssdo_gl.math3d import FloatArray, vector
from ssdo_gl.scene.geometry import Mesh
from ssdo_gl.scene.material import Material, Texture
from ssdo_gl.scene.scene_error import SceneError

# Colours of vertices, and textures, multiply the material's own.
_WHITE = Material("trimesh", albedo=(1.0, 1.0, 1.0))
_GREY = Material("trimesh")
# Textures by their names in glTF, which PBRMaterial has, and in `Material`.
_TEXTURES = {
    "baseColorTexture": "albedo_texture",
    "emissiveTexture": "emission_texture",
    "metallicRoughnessTexture": "metallic_roughness_texture",
    "normalTexture": "normal_texture",
    "occlusionTexture": "occlusion_texture",
}
_COLORS = ("baseColorTexture", "emissiveTexture")


@dataclass(frozen=True)
class Part:
    """A mesh with a material, and the (N, 4, 4) matrices that place it."""

    mesh: Mesh
    material: Material
    world_from_object: FloatArray
    name: str = ""


def trimesh_parts(item: Any) -> list[Part]:
    """Return the meshes of a ``Trimesh``, or of all nodes of a ``trimesh.Scene``.

    Raises
    ------
    SceneError
        If it holds no triangle.
    """
    parts = [_part(mesh, np.stack(matrices)) for mesh, matrices in _placed(item)]
    if not parts:
        raise SceneError(f"the {type(item).__name__} of trimesh holds no triangles")
    return parts


def undrawn(item: Any) -> list[str]:
    """Return a note of each geometry of a ``trimesh.Scene`` that has no triangles."""
    return [
        f"{name}: not drawn, a {type(geometry).__name__} of trimesh without triangles"
        for name, geometry in getattr(item, "geometry", {}).items()
        if not len(getattr(geometry, "faces", ()))
    ]


def _placed(item: Any) -> Iterator[tuple[Any, list[FloatArray]]]:
    """Yield each geometry that has triangles, with the matrices that place it."""
    if not hasattr(item, "graph"):
        if len(getattr(item, "faces", ())):
            yield item, [np.eye(4)]
        return
    places: dict[str, list[FloatArray]] = {}
    for node in item.graph.nodes_geometry:
        matrix, name = item.graph.get(node)
        places.setdefault(name, []).append(np.asarray(matrix, dtype=np.float64))
    for name, matrices in places.items():
        if len(getattr(item.geometry[name], "faces", ())):
            yield item.geometry[name], matrices


def _part(mesh: Any, matrices: FloatArray) -> Part:
    positions, triangles = np.asarray(mesh.vertices), np.asarray(mesh.faces)
    visual = mesh.visual
    uvs = colors = None
    material = _GREY
    if visual.kind == "texture" and visual.material is not None:
        material = _material(visual.material)
        if visual.uv is not None:
            # Its v grows upwards; a third would be of a volume.
            uvs = np.asarray(visual.uv, dtype=np.float64)[:, :2] * (1.0, -1.0) + (0.0, 1.0)
    elif visual.kind == "vertex":
        colors, material = np.asarray(visual.vertex_colors), _WHITE
    elif visual.kind == "face":
        colors, material = np.repeat(np.asarray(visual.face_colors), 3, axis=0), _WHITE
        positions = positions[triangles].reshape(-1, 3)
        triangles = np.arange(len(positions)).reshape(-1, 3)
    # Its own normals are smooth across creases, too, unless they are those of a file.
    name = str(mesh.metadata.get("name", ""))
    checked = Mesh.from_arrays(
        positions, triangles, normals="smooth", uvs=uvs, colors=colors, name=name
    )
    return Part(checked, material, matrices, name)


def _material(given: Any) -> Material:
    """Return a material of trimesh: metallic-roughness, or a plain one as its diffuse part."""
    name = str(getattr(given, "name", None) or "")
    if not hasattr(given, "baseColorFactor"):
        image = getattr(given, "image", None)
        diffuse = np.asarray(given.diffuse, dtype=np.float64) / 255.0
        return Material(name, vector(diffuse[:3]), albedo_texture=_texture(image, False))
    base = _factor(given.baseColorFactor, 4, 1.0)
    textures: dict[str, Any] = {
        ours: _texture(getattr(given, theirs), theirs not in _COLORS)
        for theirs, ours in _TEXTURES.items()
    }
    return Material(
        name,
        albedo=vector(base[:3]),
        alpha=float(base[3]),
        emission=vector(_factor(given.emissiveFactor, 3, 0.0)),
        metallic=_number(given.metallicFactor, 1.0),
        roughness=_number(given.roughnessFactor, 1.0),
        specular=1.0,
        blends=given.alphaMode == "BLEND",
        alpha_cutoff=_number(given.alphaCutoff, 0.5) if given.alphaMode == "MASK" else None,
        single_sided=not given.doubleSided,
        two_sided_emission=bool(given.doubleSided),
        **textures,
    )


def _factor(value: Any, count: int, usual: float) -> FloatArray:
    """Return linear factors: of uint8 in 255ths, as trimesh keeps what files say."""
    if value is None:
        return np.full(count, usual)
    array = np.asarray(value)
    factors = array.astype(np.float64) / (255.0 if array.dtype.kind in "iu" else 1.0)
    return np.append(factors, np.ones(count))[:count]


def _number(value: Any, usual: float) -> float:
    return usual if value is None else float(value)


def _texture(image: Any, is_data: bool) -> Texture | None:
    """Return a Pillow image as a texture."""
    if image is None:
        return None
    pixels = np.ascontiguousarray(np.asarray(image.convert("RGBA")))
    return Texture(pixels, is_data=is_data)
