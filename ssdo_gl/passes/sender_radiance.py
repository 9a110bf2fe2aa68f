"""The radiance that every visible surface sends on: the source of the bounce."""

from __future__ import annotations

from typing import ClassVar

from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.brdf_wiring import gloss_draws
from ssdo_gl.passes.draw_inputs import draw_inputs
from ssdo_gl.passes.terms import SenderTerms


class SenderRadiancePass(RenderPass):
    """Adds up emission and the light that surfaces reflect.

    Writes ``sender_radiance``: rgb = L_e + (albedo / pi) * irradiance, W sr^-1 m^-2,
    a = 1 on surfaces; background is 0.

    Parameters
    ----------
    glossy : bool
        Surfaces may be glossy.
    """

    overwrites: ClassVar[bool] = True

    name = "sender_radiance"

    def __init__(self, terms: SenderTerms, *, glossy: bool = False) -> None:
        self.glossy = glossy
        self.terms = terms
        self.reads = tuple(terms.wiring(glossy).values())
        self.writes = {"sender_radiance": TextureSpec(4)}

    def execute(self, context: PassContext) -> None:
        """Draw one triangle over the target, and one over what is glossy."""
        for glossy, region in gloss_draws(context.frame, self.glossy):
            defines = {**self.terms.defines(context.inputs), "GLOSSY": glossy}
            program = context.shaders.fullscreen("passes/sender_radiance.frag", defines)
            draw_inputs(context, program, {}, self.terms.wiring(bool(glossy)), region)
