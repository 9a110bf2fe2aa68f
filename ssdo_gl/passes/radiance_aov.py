"""Some terms of the picture by themselves, as radiance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.brdf_wiring import brdf_wiring
from ssdo_gl.passes.draw_inputs import draw_inputs
from ssdo_gl.passes.terms import term_defines, term_wiring


class RadianceAovPass(RenderPass):
    """Adds up what some terms add to `beauty`.

    Parameters
    ----------
    radiance : str
        Resource to write, 4 x f4: rgb radiance, a = coverage. Also names the pass.
    irradiances, radiances : sequence of str
        Resources to read, e.g. ``direct_irradiance``.
    glossy : bool
        Surfaces may be glossy.
    """

    overwrites: ClassVar[bool] = True

    def __init__(
        self,
        radiance: str,
        irradiances: Sequence[str] = (),
        radiances: Sequence[str] = (),
        *,
        glossy: bool = False,
    ) -> None:
        self.name = radiance
        self._wiring = {**brdf_wiring(glossy), **term_wiring(irradiances, radiances)}
        if glossy:
            self._wiring |= {"t_z_vs": "z_vs", "t_normals_vs": "normals_vs"}
        self.reads = tuple(self._wiring.values())
        self.writes = {radiance: TextureSpec(4, "f4")}
        self._glossy = glossy
        self._defines = {**term_defines(irradiances, radiances), "GLOSSY": int(glossy)}

    def execute(self, context: PassContext) -> None:
        program = context.shaders.fullscreen("passes/radiance_aov.frag", self._defines)
        uniforms = context.frame.view.uniforms() if self._glossy else {}
        draw_inputs(context, program, uniforms, self._wiring)
