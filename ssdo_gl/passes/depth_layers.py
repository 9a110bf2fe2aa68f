"""Fronts and backs of solids in one texture."""

from __future__ import annotations

from collections.abc import Mapping

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec


class DepthLayersPass(RenderPass):
    """Packs ``z_vs`` and ``z_back_vs`` into the two channels of ``z_layers``.

    A march that fetches them apart takes half as long again (llvmpipe, 4 directions of 8
    steps: 22 ms against 13 ms of processor time for 65,000 pixels); packing takes 1 ms.
    """

    name = "depth_layers"
    reads = ("z_vs", "z_back_vs")
    writes: Mapping[str, TextureSpec] = {"z_layers": TextureSpec(2)}

    def execute(self, context: PassContext) -> None:
        """Draw one triangle over the target."""
        assert context.target is not None
        draw_fullscreen(
            context.gl,
            context.shaders.fullscreen("effects/depth_layers.frag"),
            context.target,
            {},
            {f"t_{name}": context.inputs[name] for name in self.reads},
        )
