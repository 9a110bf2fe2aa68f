"""The scene's triangles as a hierarchy that shaders can trace rays through."""

from __future__ import annotations

from collections.abc import Mapping

from ssdo_gl.graph.render_pass import PassContext, RenderPass, TextureWithFacts
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.rays.ray_libraries import record_texture
from ssdo_gl.raytracing.bvh import cached_bvh
from ssdo_gl.raytracing.surface_tables import material_words

# Of fewer it takes no time that one would like to see pass.
MANY_TRIANGLES = 200_000


class BvhUploadPass(RenderPass):
    """Uploads `bvh`: the records of `raytracing.bvh.Bvh`, materials named.

    Words 13 and 14 of a primitive are the materials of its triangles, with the flags of
    `raytracing.surface_tables`. The `Bvh` itself comes with the resource: what is made
    from triangles, and what says where they are, takes it from there.
    """

    name = "bvh_upload"
    writes: Mapping[str, TextureSpec] = {"bvh": TextureSpec(4, "u4", own=True)}
    depends_on = ("geometry",)

    def execute(self, context: PassContext) -> dict[str, TextureWithFacts]:
        """Build the hierarchy unless the scene's is known, and return it as a texture."""
        scene, progress = context.frame.scene, context.progress
        if progress is None or context.frame.is_live or scene.triangle_count < MANY_TRIANGLES:
            bvh = cached_bvh(scene)
        else:
            bvh = cached_bvh(scene, lambda share: progress("hierarchy", int(100 * share), 100))
            progress("hierarchy", 100, 100)
        records = bvh.records()
        records[bvh.primitive_records, 13:15] = material_words(bvh, scene)
        texture = record_texture(context.gl, len(records), "u4", lambda span: records[span])
        return {"bvh": TextureWithFacts(texture, bvh)}
