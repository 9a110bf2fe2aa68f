"""The radiance that every visible surface sends on: the source of the bounce."""

from __future__ import annotations

from collections.abc import Hashable

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec


class SenderRadiancePass(RenderPass):
    """Adds up emission and reflected direct and directional light.

    Writes ``sender_radiance``: rgb = L_e + (albedo / pi) * irradiance, W sr^-1 m^-2,
    a = 1 on surfaces; background is 0.

    Parameters
    ----------
    has_direct : bool
        Read ``direct_irradiance``.
    has_directional : bool
        Read ``directional_irradiance``.
    has_emission : bool
        Read ``emission``: some of it is delivered by no light.
    """

    def __init__(
        self,
        *,
        has_direct: bool = True,
        has_directional: bool = True,
        has_emission: bool = True,
    ) -> None:
        self.name = "sender_radiance"
        self.reads = (
            "albedo",
            *(("emission",) if has_emission else ()),
            *(("direct_irradiance",) if has_direct else ()),
            *(("directional_irradiance",) if has_directional else ()),
        )
        self.writes = {"sender_radiance": TextureSpec(4)}
        self._defines = {
            "HAS_DIRECT": int(has_direct),
            "HAS_DIRECTIONAL": int(has_directional),
            "HAS_EMISSION": int(has_emission),
        }

    def settings_key(self) -> Hashable:
        """Return the switches."""
        return tuple(self._defines.items())

    def execute(self, context: PassContext) -> None:
        """Draw one triangle over the target."""
        assert context.target is not None
        draw_fullscreen(
            context.gl,
            context.shaders.fullscreen("passes/sender_radiance.frag", self._defines),
            context.target,
            {},
            {f"t_{name}": context.inputs[name] for name in self.reads},
        )
