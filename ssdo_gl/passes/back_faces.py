"""A second depth layer: the backs of solids."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import moderngl

from ssdo_gl.gpu.draw_group import Features
from ssdo_gl.gpu.shader import Program
from ssdo_gl.graph.depth_range import depth_uniforms, wide_depth_range
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec


class BackFacesPass(RenderPass):
    """Writes `z_back_vs`: distance of the nearest back face, 0 where there is none.

    Only closed meshes without cut-outs are drawn: the back of anything else bounds
    no solid.
    """

    name = "back_faces"
    writes: Mapping[str, TextureSpec] = {"z_back_vs": TextureSpec(1, "f4")}
    depends_on = ("view", "geometry")
    needs_depth: ClassVar[bool] = True

    def execute(self, context: PassContext) -> None:
        """Draw every visible solid, front faces culled."""
        assert context.target is not None
        view = context.frame.view
        defines = {"WIDE_DEPTH_RANGE": wide_depth_range(view.near, view.far)}

        def program_of(features: Features) -> Program:
            return context.shaders.program(
                "effects/back_faces.vert", "effects/back_faces.frag", defines
            )

        context.target.use()
        context.gl.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        context.gl.cull_face = "front"
        context.geometry.draw(
            view,
            view.clip_from_view,
            program_of,
            depth_uniforms(view.near, view.far),
            solids_only=True,
        )
        context.gl.enable_only(moderngl.NOTHING)
