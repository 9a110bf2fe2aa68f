"""One term of the picture by itself, as radiance."""

from __future__ import annotations

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec


class RadianceAovPass(RenderPass):
    """Turns an irradiance into the radiance that it adds to `beauty`.

    Parameters
    ----------
    irradiance : str
        Resource to read, e.g. ``direct_irradiance``.
    radiance : str
        Resource to write, 4 x f4: rgb radiance, a = coverage. Also names the pass.
    """

    def __init__(self, irradiance: str, radiance: str) -> None:
        self.name = radiance
        self.reads = ("albedo", irradiance)
        self.writes = {radiance: TextureSpec(4, "f4")}
        self._irradiance = irradiance

    def execute(self, context: PassContext) -> None:
        """Draw one full-screen triangle."""
        assert context.target is not None
        textures = {
            "t_albedo": context.inputs["albedo"],
            "t_irradiance": context.inputs[self._irradiance],
        }
        program = context.shaders.fullscreen("passes/radiance_aov.frag")
        draw_fullscreen(context.gl, program, context.target, {}, textures)
