"""The lights of the scene, in view space, where shaders can read them."""

from __future__ import annotations

from collections.abc import Mapping

import moderngl

from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.graph.light_rows import light_rows
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.graph.shadow_frames import shadow_frames


class LightTablePass(RenderPass):
    """Uploads `lights`: made relative to the camera in float64, stored in float32."""

    name = "light_table"
    writes: Mapping[str, TextureSpec] = {"lights": TextureSpec(4, "f4", own=True)}
    # The shadow map of a directional light encloses the scene.
    depends_on = ("view", "lights", "geometry")

    def execute(self, context: PassContext) -> dict[str, moderngl.Texture]:
        """Return the table as a new texture."""
        lights = context.frame.scene.lights
        frames = shadow_frames(lights, context.geometry.bounds_along)
        rows = light_rows(lights, frames, context.frame.view)
        return {"lights": make_texture(context.gl, (rows.shape[1], rows.shape[0]), 4, "f4", rows)}
