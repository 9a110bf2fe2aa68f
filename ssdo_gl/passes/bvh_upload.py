"""The scene's triangles as a hierarchy that shaders can trace rays through."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.graph.render_pass import PassContext, RenderPass, TextureWithFacts
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.ray_uniforms import folded
from ssdo_gl.raytracing.bvh import cached_bvh
from ssdo_gl.raytracing.surface_tables import material_words


class BvhUploadPass(RenderPass):
    """Uploads `bvh`: the records of `raytracing.bvh.Bvh`, 256 to a row, materials named.

    Words 13 and 14 of a primitive are the materials of its triangles, with the flags of
    `raytracing.surface_tables`. The `Bvh` itself comes with the resource: what is made
    from triangles, and what says where they are, takes it from there.
    """

    name = "bvh_upload"
    writes: Mapping[str, TextureSpec] = {"bvh": TextureSpec(4, "u4", own=True)}
    depends_on = ("geometry",)

    def execute(self, context: PassContext) -> dict[str, TextureWithFacts]:
        """Build the hierarchy unless the scene's is known, and return it as a texture."""
        bvh = cached_bvh(context.frame.scene)
        records = bvh.records.copy()
        # A node never has a primitive's number: its words from 11 on are zero.
        is_primitive = np.ones(len(records), dtype=bool)
        is_primitive[bvh.node_records] = False
        words = material_words(bvh, context.frame.scene)
        records[is_primitive, 13:15] = words[records[is_primitive, 12]]
        image = folded(records)
        size = image.shape[1], image.shape[0]
        texture = make_texture(context.gl, size, 4, "u4", image)
        return {"bvh": TextureWithFacts(texture, bvh)}
