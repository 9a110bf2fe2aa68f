"""Light that arrives straight from the scene's lights."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.graph.frame import Frame
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.graph.settings import setting
from ssdo_gl.graph.shadow_frames import column_count
from ssdo_gl.passes.screen_space_settings import pattern_offset


@dataclass(frozen=True)
class DirectSettings:
    """How soft shadows of rectangle lights are sampled."""

    blocker_samples: int = setting(
        8, "shadow-map reads that look for what stands before a light", low=1, high=256
    )
    filter_samples: int = setting(
        16, "shadow-map reads in a penumbra: smoother", low=1, high=256
    )


def uniforms(settings: DirectSettings, frame: Frame) -> dict[str, object]:
    """Return the uniforms of ``direct.frag``."""
    return {
        **frame.view.uniforms(),
        "u_light_count": len(frame.scene.lights),
        "u_shadow_columns": column_count(frame.scene.lights),
        "u_pattern_offset": pattern_offset(frame.seed),
    }


class DirectPass(RenderPass):
    """Writes `direct_irradiance`: rgb irradiance, a = 1 on surfaces; background 0.

    Points, spots and directional lights are exact; rectangles by Lambert's polygon
    formula. Linear in the light; exactly 0 where none arrives.

    Parameters
    ----------
    settings : DirectSettings
    shadow_maps : bool
        Read `shadow_atlas` for lights whose shadow is "map"; else they cast none.
    """

    name = "direct"
    writes: Mapping[str, TextureSpec] = {"direct_irradiance": TextureSpec(4, "f4")}

    def __init__(
        self, settings: DirectSettings | None = None, *, shadow_maps: bool = True
    ) -> None:
        self.settings = settings or DirectSettings()
        self.shadow_maps = shadow_maps
        self.reads = ("z_vs", "normals_vs", "lights", *(("shadow_atlas",) if shadow_maps else ()))
        # The seed turns the pattern of soft shadows, which only maps have.
        self.depends_on = ("view", "lights", *(("seed",) if shadow_maps else ()))

    def settings_key(self) -> Hashable:
        """Return the settings and whether there are shadow maps."""
        return self.settings, self.shadow_maps

    def execute(self, context: PassContext) -> None:
        """Draw one full-screen triangle."""
        assert context.target is not None
        defines = {
            "HAS_SHADOW_MAPS": int(self.shadow_maps),
            "BLOCKER_COUNT": self.settings.blocker_samples,
            "FILTER_COUNT": self.settings.filter_samples,
        }
        draw_fullscreen(
            context.gl,
            context.shaders.fullscreen("direct.frag", defines),
            context.target,
            uniforms(self.settings, context.frame),
            {f"t_{name}": context.inputs[name] for name in self.reads},
        )
