"""Tables for rays that shade what they hit: surfaces, materials, textures, emitters."""

from __future__ import annotations

from collections.abc import Mapping

import moderngl
import numpy as np
from numpy.typing import NDArray

from ssdo_gl.gpu.material_textures import GL_SRGB8_ALPHA8
from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.graph.render_pass import PassContext, Produced, RenderPass, TextureWithFacts
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.ray_uniforms import bvh_of, folded
from ssdo_gl.raytracing.emitter_tables import emitter_tables, map_cells, map_mean_radiance
from ssdo_gl.raytracing.surface_tables import (
    Atlas,
    RayFeatures,
    build_atlas,
    material_table,
    surface_table,
)
from ssdo_gl.scene.environment_kinds import MapEnvironment
from ssdo_gl.scene.environment_light import radiance_image
from ssdo_gl.scene.scene import Scene


class SurfaceTablesPass(RenderPass):
    """Uploads `ray_surfaces` and `ray_atlas`; `Atlas.places` come with the latter.

    Tables that no object of the scene needs are a single texel.
    """

    name = "surface_tables"
    reads = ("bvh",)
    writes: Mapping[str, TextureSpec] = {
        "ray_surfaces": TextureSpec(4, "u4", own=True),
        "ray_atlas": TextureSpec(4, "nu1", own=True),
    }
    depends_on = ("geometry",)

    def execute(self, context: PassContext) -> Produced:
        """Return the tables as new textures."""
        gl, scene = context.gl, context.frame.scene
        features = RayFeatures.of(scene)
        atlas = _atlas(gl, scene) if features.textures else None
        if features.needs_corners:
            surfaces = folded(surface_table(bvh_of(context)))
        else:
            surfaces = np.zeros((1, 1, 4), dtype=np.uint32)
        size = surfaces.shape[1], surfaces.shape[0]
        return {
            "ray_surfaces": make_texture(gl, size, 4, "u4", surfaces),
            "ray_atlas": TextureWithFacts(_upload_atlas(gl, atlas), atlas.places if atlas else {}),
        }


def _atlas(gl: moderngl.Context, scene: Scene) -> Atlas:
    images = [m.albedo_texture for m in scene.materials]
    images += [m.emission_texture for m in scene.materials]
    largest = int(gl.info["GL_MAX_TEXTURE_SIZE"])
    return build_atlas([image for image in images if image is not None], largest)


def _upload_atlas(gl: moderngl.Context, atlas: Atlas | None) -> moderngl.Texture:
    if atlas is None:
        return make_texture(gl, (1, 1), 4, "nu1", np.ones((1, 1, 4)))
    size = atlas.pixels.shape[1], atlas.pixels.shape[0]
    if atlas.pixels.dtype != np.uint8:
        return make_texture(gl, size, 4, "f4", atlas.pixels)
    # The hardware decodes sRGB when a texel is fetched.
    texture = gl.texture(
        size, 4, atlas.pixels.tobytes(), dtype="f1", internal_format=GL_SRGB8_ALPHA8
    )
    texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
    return texture


class MaterialTablePass(RenderPass):
    """Uploads `ray_materials`, which also says which lights pass through everything."""

    name = "material_table"
    reads = ("ray_atlas",)
    writes: Mapping[str, TextureSpec] = {"ray_materials": TextureSpec(4, "f4", own=True)}
    depends_on = ("geometry", "lights")

    def execute(self, context: PassContext) -> dict[str, moderngl.Texture]:
        """Return the table as a new texture."""
        rows = material_table(context.frame.scene, context.facts["ray_atlas"])
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
    depends_on = ("geometry", "lights", "environment")

    def execute(self, context: PassContext) -> Produced:
        """Return the tables as new textures."""
        gl, scene = context.gl, context.frame.scene
        map_power = 0.0
        cells = np.ones((1, 1, 4), dtype=np.float32)
        if isinstance(scene.environment, MapEnvironment):
            image = radiance_image(scene.environment).astype(np.float32)
            cells = map_cells(image) if image[..., :3].any() else cells
            map_power = map_mean_radiance(image)
        tables = emitter_tables(bvh_of(context), scene, map_power)
        # An entry takes two records: 128 entries to a row.
        entries = folded(tables.entries.reshape(-1, 16))
        return {
            "ray_emitters": TextureWithFacts(_table(gl, entries), tables),
            "ray_emitter_groups": _table(gl, tables.groups),
            "ray_map_cells": _table(gl, cells),
        }


def _table(gl: moderngl.Context, rows: NDArray[np.float32]) -> moderngl.Texture:
    return make_texture(gl, (rows.shape[1], rows.shape[0]), 4, "f4", rows)
