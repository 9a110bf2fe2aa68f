"""From linear radiance to what a display shows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.draw_inputs import draw_inputs
from ssdo_gl.settings.backgrounds import ENVIRONMENT, TRANSPARENT, background_color
from ssdo_gl.settings.fields import setting
from ssdo_gl.settings.settings import same_as

CURVES = ("aces", "plain")


@dataclass(frozen=True)
class ToneMapSettings:
    """How radiance becomes a picture."""

    exposure: float = same_as("exposure", 0.0)
    background: str = same_as("background", ENVIRONMENT)
    curve: str = setting(
        "plain",
        "plain shows radiance 1 as white and clips above; aces rolls highlights off",
        choices=CURVES,
    )


def uniforms(settings: ToneMapSettings) -> dict[str, object]:
    """Return the uniforms of ``passes/tone_map.frag``."""
    result: dict[str, object] = {"u_exposure_scale": 2.0**settings.exposure}
    color = background_color(settings.background)
    if color is not None:
        result["u_background"] = color
    return result


def defines(settings: ToneMapSettings) -> dict[str, int]:
    """Return the defines of ``passes/tone_map.frag``."""
    background = {ENVIRONMENT: 0, TRANSPARENT: 2}.get(settings.background, 1)
    return {"TONE_CURVE": int(settings.curve == "aces"), "BACKGROUND": background}


class ToneMapPass(RenderPass):
    """The picture (scene-linear) to `display`, sRGB-encoded; its alpha is 0 where nothing is seen.

    In 16 bits a channel: whoever makes 8 of them dithers, which needs the rest.

    Parameters
    ----------
    source : str
        Resource that holds the picture.
    """

    name = "tone_map"
    writes: Mapping[str, TextureSpec] = {"display": TextureSpec(4, "nu2")}

    overwrites: ClassVar[bool] = True

    def __init__(self, settings: ToneMapSettings | None = None, source: str = "beauty") -> None:
        self.settings = settings or ToneMapSettings()
        self.reads = (source,)
        self.defines, self.uniforms = defines(self.settings), uniforms(self.settings)

    def execute(self, context: PassContext) -> None:
        program = context.shaders.fullscreen("passes/tone_map.frag", self.defines)
        draw_inputs(context, program, self.uniforms, {"t_beauty": self.reads[0]})
