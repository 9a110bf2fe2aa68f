"""The radiance that every visible surface sends on: the source of the bounce."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import ClassVar

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.brdf_wiring import brdf_wiring, gloss_draws
from ssdo_gl.passes.terms import term_defines, term_wiring


class SenderRadiancePass(RenderPass):
    """Adds up emission and the light that surfaces reflect.

    Writes ``sender_radiance``: rgb = L_e + (albedo / pi) * irradiance, W sr^-1 m^-2,
    a = 1 on surfaces; background is 0.

    Parameters
    ----------
    irradiances : sequence of str
        Resources of what arrives, full size or half of it, rgb.
    radiances : sequence of str
        Resources of what is emitted; only where their alpha is 1.
    glossy : bool
        Surfaces may be glossy.
    """

    overwrites: ClassVar[bool] = True

    name = "sender_radiance"

    def __init__(
        self,
        irradiances: Sequence[str] = (),
        radiances: Sequence[str] = (),
        *,
        glossy: bool = False,
    ) -> None:
        self._glossy = glossy
        self._irradiances = tuple(irradiances)
        self._terms = term_wiring(irradiances, radiances)
        self._defines = term_defines(irradiances, radiances)
        self.reads = (*brdf_wiring(glossy).values(), *self._terms.values())
        self.writes = {"sender_radiance": TextureSpec(4)}

    def settings_key(self) -> Hashable:
        return self._glossy, tuple(self._defines.items())

    def execute(self, context: PassContext) -> None:
        """Draw one triangle over the target, and one over what is glossy."""
        assert context.target is not None
        sizes = [context.inputs[name].size for name in self._irradiances]
        half = sum((size != context.target.size) << i for i, size in enumerate(sizes))
        for glossy, region in gloss_draws(context.frame, self._glossy):
            defines = {**self._defines, "HALF_IRRADIANCES": half, "GLOSSY": glossy}
            wiring = {**brdf_wiring(bool(glossy)), **self._terms}
            draw_fullscreen(
                context.gl,
                context.shaders.fullscreen("passes/sender_radiance.frag", defines),
                context.target,
                {},
                {sampler: context.inputs[name] for sampler, name in wiring.items()},
                region=region,
            )
