"""Which objects one draw call can render together, and what their program needs."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field

import moderngl
import numpy as np
from numpy.typing import NDArray

from ssdo_gl.gpu.shader import Program
from ssdo_gl.gpu.vertices import VertexStreams
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.mesh import Mesh
from ssdo_gl.scene.scene import Scene

# Per-instance data: three rows of view_from_object; albedo (rgb, alpha factor);
# emission (rgb, 1 if it may count as a sender); (1 if both sides emit, alpha cutoff).
INSTANCE_ATTRIBUTES = (
    ("a_view_from_object_row_0", 4),
    ("a_view_from_object_row_1", 4),
    ("a_view_from_object_row_2", 4),
    ("a_albedo", 4),
    ("a_emission", 4),
    ("a_emission_side_cutoff", 2),
)
INSTANCE_FLOATS = sum(count for _, count in INSTANCE_ATTRIBUTES)


@dataclass(frozen=True)
class Features:
    """What the objects of one draw call need from its program.

    A program compiled without what nobody needs does not pay for it. Where instances do
    not differ in their material, `material_uniforms` are set instead of attributes.
    """

    shading_normals: bool = False
    vertex_colors: bool = False
    albedo_texture: bool = False
    emission_texture: bool = False
    emission_uvs: bool = False
    alpha_cutout: bool = False
    instance_materials: bool = False
    single_sided: bool = False

    def defines(self) -> dict[str, int]:
        """Return the switches for a shader that outputs materials."""
        return {
            "HAS_SHADING_NORMALS": int(self.shading_normals),
            "HAS_VERTEX_COLORS": int(self.vertex_colors),
            "HAS_ALBEDO_TEXTURE": int(self.albedo_texture),
            "HAS_EMISSION_TEXTURE": int(self.emission_texture),
            "HAS_EMISSION_UVS": int(self.emission_uvs),
            "HAS_ALPHA_CUTOUT": int(self.alpha_cutout),
            "HAS_INSTANCE_MATERIALS": int(self.instance_materials),
        }

    def cutout_defines(self) -> dict[str, int]:
        """Return the switches for a shader that outputs depth only."""
        return {
            "HAS_VERTEX_COLORS": int(self.alpha_cutout and self.vertex_colors),
            "HAS_ALBEDO_TEXTURE": int(self.alpha_cutout and self.albedo_texture),
            "HAS_ALPHA_CUTOUT": int(self.alpha_cutout),
        }


@dataclass(eq=False)
class DrawGroup:
    """Device objects for instances that one draw call renders: same mesh, same textures.

    `key` is equal for groups that can stand in for each other.
    """

    key: Hashable
    mesh: Mesh
    vertices: VertexStreams
    features: Features
    textures: Mapping[str, moderngl.Texture]
    instances: moderngl.Buffer
    vertex_arrays: dict[Program, moderngl.VertexArray] = field(default_factory=dict)

    @property
    def is_solid(self) -> bool:
        """Whether its back faces bound solids."""
        return self.vertices.is_solid and not self.features.alpha_cutout

    def release(self) -> None:
        """Free the vertex arrays and the instance buffer; the mesh's buffers are shared."""
        for array in self.vertex_arrays.values():
            array.release()
        self.instances.release()


def grouped(scene: Scene) -> list[list[int]]:
    """Return lists of object indices that one draw call can render together."""
    groups: dict[tuple[int, Features, int, int], list[int]] = {}
    for i, item in enumerate(scene.objects):
        material = scene.materials[item.material]
        features = features_of(scene.meshes[item.mesh], material)
        key = (
            item.mesh,
            features,
            id(material.albedo_texture) if features.albedo_texture else 0,
            id(material.emission_texture) if features.emission_texture else 0,
        )
        groups.setdefault(key, []).append(i)
    return list(groups.values())


def features_of(mesh: Mesh, material: Material) -> Features:
    """Return what drawing `mesh` with `material` needs."""
    textured = mesh.uvs is not None
    glow_textured = textured and material.emission_texture is not None and material.emits
    return Features(
        shading_normals=mesh.normals is not None,
        vertex_colors=mesh.colors is not None,
        albedo_texture=textured and material.albedo_texture is not None,
        emission_texture=glow_textured,
        emission_uvs=glow_textured and mesh.emission_uvs is not None,
        alpha_cutout=material.alpha_cutoff is not None,
        single_sided=material.single_sided,
    )


def material_uniforms(row: NDArray[np.float32]) -> dict[str, object]:
    """Return the uniforms that stand for the attributes of a `material_row`."""
    return {
        "u_albedo": row[0:4],
        "u_emission": row[4:8],
        "u_emission_side_cutoff": row[8:10],
    }


def material_row(material: Material, counts_as_sender: bool) -> FloatArray:
    """Return the instance attributes that come from a material, in order."""
    return np.array(
        [
            *material.albedo,
            material.alpha,
            *material.emission,
            float(counts_as_sender),
            float(material.two_sided_emission),
            0.0 if material.alpha_cutoff is None else material.alpha_cutoff,
        ]
    )
