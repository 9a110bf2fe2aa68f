"""Which objects one draw call can render together, and what their program needs."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import moderngl
import numpy as np
from numpy.typing import NDArray

from ssdo_gl.gpu.geometry.vertices import VertexStreams
from ssdo_gl.gpu.program import Program
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.geometry import Mesh
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

# The images of a material, as `Material.textures` names them.
IMAGE_NAMES = (
    "albedo",
    "emission",
    "metallic_roughness",
    "specular",
    "specular_color",
    "normal",
    "occlusion",
)
# Those that only gloss needs.
GLOSS_IMAGES = frozenset({"metallic_roughness", "specular", "specular_color"})


@dataclass(frozen=True)
class Features:
    """What the objects of one draw call need from its program.

    A program compiled without what nobody needs does not pay for it.

    Attributes
    ----------
    emits, by_chance : bool
        Whether any of them shows something where no light falls, and whether any is
        translucent; known of batches, not of groups.
    images, second_uvs : frozenset of str
        Of `IMAGE_NAMES`: those that there are, and those of them that take the mesh's
        second texture coordinates.
    """

    shading_normals: bool = False
    tangents: bool = False
    vertex_colors: bool = False
    alpha_cutout: bool = False
    single_sided: bool = False
    glossy: bool = False
    emits: bool = False
    by_chance: bool = False
    images: frozenset[str] = frozenset()
    second_uvs: frozenset[str] = frozenset()

    @cached_property
    def defines(self) -> Mapping[str, int]:
        """The switches for a shader that outputs materials."""
        return {
            "HAS_SHADING_NORMALS": int(self.shading_normals),
            "HAS_TANGENTS": int(self.tangents),
            "HAS_VERTEX_COLORS": int(self.vertex_colors),
            "HAS_ALPHA_CUTOUT": int(self.alpha_cutout),
            "HAS_GLOSS": int(self.glossy),
            **{f"HAS_{name.upper()}_IMAGE": int(name in self.images) for name in IMAGE_NAMES},
            **{
                f"{name.upper()}_ON_SECOND_UVS": int(name in self.second_uvs)
                for name in IMAGE_NAMES
            },
        }

    def cutout_defines(self) -> dict[str, int]:
        """Return the switches for a shader that outputs depth only."""
        return {
            "HAS_VERTEX_COLORS": int(self.alpha_cutout and self.vertex_colors),
            "HAS_ALBEDO_TEXTURE": int(self.alpha_cutout and "albedo" in self.images),
            "HAS_ALPHA_CUTOUT": int(self.alpha_cutout),
            "ALBEDO_ON_SECOND_UVS": int(self.alpha_cutout and "albedo" in self.second_uvs),
        }


@dataclass(eq=False)
class DrawGroup:
    """Device objects for instances that one draw call renders: same mesh, same textures.

    `key` is equal for groups that can stand in for each other. `attributes` is what
    `instances` holds.
    """

    key: Hashable
    mesh: Mesh
    vertices: VertexStreams
    features: Features
    textures: Mapping[str, moderngl.Texture]
    instances: moderngl.Buffer
    vertex_arrays: dict[Program, moderngl.VertexArray] = field(default_factory=dict)
    attributes: NDArray[np.float32] | None = None

    @property
    def is_solid(self) -> bool:
        """Whether its back faces bound solids."""
        return self.vertices.is_solid and not self.features.alpha_cutout

    def hold(self, attributes: NDArray[np.float32]) -> None:
        """Have `instances` hold these."""
        if self.attributes is attributes:
            return
        # Orphaned, so that writing need not wait for the draw call before.
        self.instances.orphan()
        self.instances.write(attributes)
        self.attributes = attributes

    def release(self) -> None:
        """Free the vertex arrays and the instance buffer; the mesh's buffers are shared."""
        for array in self.vertex_arrays.values():
            array.release()
        self.instances.release()


def grouped(scene: Scene) -> list[list[int]]:
    """Return lists of object indices that one draw call can render together."""
    groups: dict[tuple[int, Features, tuple[int, ...]], list[int]] = {}
    for i, item in enumerate(scene.objects):
        material = scene.materials[item.material]
        features = features_of(scene.meshes[item.mesh], material)
        textures = material.textures
        images = tuple(id(textures[name]) for name in IMAGE_NAMES if name in features.images)
        groups.setdefault((item.mesh, features, images), []).append(i)
    return list(groups.values())


def features_of(mesh: Mesh, material: Material) -> Features:
    """Return what drawing `mesh` with `material` needs."""
    images = frozenset(material.textures if mesh.uvs is not None else ())
    images -= frozenset() if material.emits else frozenset({"emission"})
    images -= frozenset() if material.is_glossy else GLOSS_IMAGES
    return Features(
        shading_normals=mesh.normals is not None,
        tangents=mesh.has_tangents and "normal" in images,
        vertex_colors=mesh.colors is not None,
        alpha_cutout=material.has_holes,
        single_sided=material.single_sided,
        glossy=material.is_glossy,
        images=images,
        second_uvs=images & material.second_uvs if mesh.second_uvs is not None else frozenset(),
    )


def emitting(rows: NDArray[np.float32]) -> bool:
    """Return whether a `material_row` of these shows anything where no light falls."""
    # The second: what is unlit, whose colour passes/gbuffer.frag puts out as emission.
    return bool(np.any(rows[:, 4:7] > 0.0) or np.any(rows[:, 8] > 1.5))


def by_chance(rows: NDArray[np.float32]) -> bool:
    """Return whether a `material_row` of these is translucent."""
    return bool(np.any(rows[:, 9] < 0.0))


def material_row(material: Material, counts_as_sender: bool) -> FloatArray:
    """Return the instance attributes that come from a material, in order."""
    return np.array(
        [
            *material.albedo,
            material.alpha,
            *material.emission,
            float(counts_as_sender),
            material.side_code,
            -1.0 if material.is_translucent else material.alpha_cutoff or 0.0,
            material.metallic,
            material.roughness,
            material.normal_scale,
            material.occlusion_strength,
            *material.dielectric_color,
            material.specular,
        ]
    )
