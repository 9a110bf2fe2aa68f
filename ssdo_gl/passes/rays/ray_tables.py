"""Tables for rays that shade what they hit: surfaces, materials, textures, emitters."""

from __future__ import annotations

from collections.abc import Mapping

import moderngl
import numpy as np
from numpy.typing import NDArray

from ssdo_gl.gpu.texture import image_texture, make_texture
from ssdo_gl.graph.render_pass import PassContext, Produced, RenderPass, TextureWithFacts
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.rays.ray_libraries import bvh_of, record_texture
from ssdo_gl.raytracing.emitter_tables import emitter_tables, map_cells, map_mean_radiance
from ssdo_gl.raytracing.surface_tables import (
    IMAGE_TEXELS,
    RayFeatures,
    build_atlas,
    material_table,
    surface_count,
    surface_table,
)
from ssdo_gl.scene.environment import MapEnvironment, radiance_image
from ssdo_gl.scene.scene import Scene


class SurfaceTablesPass(RenderPass):
    """Uploads `ray_surfaces` and the atlases; `Atlas.places` come with the latter.

    `ray_atlas` holds images of colour, `ray_data_atlas` those whose numbers count.

    Tables that no object of the scene needs are a single texel.
    """

    name = "surface_tables"
    reads = ("bvh",)
    writes: Mapping[str, TextureSpec] = {
        "ray_surfaces": TextureSpec(4, "u4", own=True),
        "ray_atlas": TextureSpec(4, "nu1", own=True),
        "ray_data_atlas": TextureSpec(4, "nu1", own=True),
    }
    depends_on = ("geometry",)

    def execute(self, context: PassContext) -> Produced:
        gl, scene = context.gl, context.frame.scene
        features = RayFeatures.of(scene)
        bvh = bvh_of(context)
        if features.needs_corners:
            count = surface_count(bvh)
            surfaces = record_texture(
                gl, count, "u4", lambda span: surface_table(bvh, span), features.corner_texels
            )
        else:
            surfaces = make_texture(gl, (1, 1), 4, "u4", np.zeros((1, 1, 4)))
        return {
            "ray_surfaces": surfaces,
            "ray_atlas": _atlas(gl, scene, is_data=False),
            "ray_data_atlas": _atlas(gl, scene, is_data=True),
        }


def _atlas(gl: moderngl.Context, scene: Scene, *, is_data: bool) -> TextureWithFacts:
    """Return an atlas of the images whose uint8 values are, or are not, data."""
    drawn = [(scene.meshes[o.mesh], scene.materials[o.material]) for o in scene.objects]
    images = [
        texture
        for mesh, material in drawn
        if mesh.uvs is not None
        for name, texture in material.textures.items()
        if name in IMAGE_TEXELS and texture.is_data == is_data
    ]
    if not images:
        return TextureWithFacts(make_texture(gl, (1, 1), 4, "nu1", np.ones((1, 1, 4))), {})
    atlas = build_atlas(images, int(gl.info["GL_MAX_TEXTURE_SIZE"]))
    texture = image_texture(gl, atlas.pixels, is_data=is_data)
    texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
    return TextureWithFacts(texture, atlas.places)


class MaterialTablePass(RenderPass):
    """Uploads `ray_materials`, which also says which lights pass through everything."""

    name = "material_table"
    reads = ("ray_atlas", "ray_data_atlas")
    writes: Mapping[str, TextureSpec] = {"ray_materials": TextureSpec(4, "f4", own=True)}
    depends_on = ("geometry", "materials", "lights")

    def execute(self, context: PassContext) -> dict[str, moderngl.Texture]:
        places = {**context.facts["ray_atlas"], **context.facts["ray_data_atlas"]}
        rows = material_table(context.frame.scene, places)
        return {"ray_materials": _table(context.gl, rows)}


class EmitterTablesPass(RenderPass):
    """Uploads `ray_emitters`, `ray_emitter_groups` and `ray_map_cells`.

    The `EmitterTables` come with `ray_emitters`.
    """

    name = "emitter_tables"
    reads = ("bvh",)
    writes: Mapping[str, TextureSpec] = {
        "ray_emitters": TextureSpec(4, "f4", own=True),
        "ray_emitter_groups": TextureSpec(4, "f4", own=True),
        "ray_map_cells": TextureSpec(4, "f4", own=True),
    }
    depends_on = ("geometry", "materials", "lights", "environment")

    def execute(self, context: PassContext) -> Produced:
        gl, scene = context.gl, context.frame.scene
        map_power = 0.0
        cells = np.ones((1, 1, 4), dtype=np.float32)
        if isinstance(scene.environment, MapEnvironment):
            image = radiance_image(scene.environment).astype(np.float32)
            cells = map_cells(image) if image[..., :3].any() else cells
            map_power = map_mean_radiance(image)
        tables = emitter_tables(bvh_of(context), scene, map_power)
        entries = tables.entries.reshape(-1, 16)
        texture = record_texture(gl, len(entries), "f4", lambda span: entries[span])
        return {
            "ray_emitters": TextureWithFacts(texture, tables),
            "ray_emitter_groups": _table(gl, _in_rows(tables.groups)),
            "ray_map_cells": _table(gl, cells),
        }


def _in_rows(groups: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return groups (G, 2, 4) as rows of 256 each."""
    padded = np.zeros((-(-len(groups) // 256) * 256, *groups.shape[1:]), np.float32)
    padded[: len(groups)] = groups
    return padded.reshape(-1, 512, 4)


def _table(gl: moderngl.Context, rows: NDArray[np.float32]) -> moderngl.Texture:
    return make_texture(gl, (rows.shape[1], rows.shape[0]), 4, "f4", rows)
