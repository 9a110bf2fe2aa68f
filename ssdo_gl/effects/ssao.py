"""Ambient visibility from the depth buffer."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from ssdo_gl.effects.ambient import combine_of, need_of_visibility
from ssdo_gl.effects.effect import Effect, ImageSource, ReasonedPass
from ssdo_gl.effects.near_field import OPEN_DIRECTIONS, estimator_settings, filtered
from ssdo_gl.effects.request import Decision, Request
from ssdo_gl.graph.frame import Frame
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.composite import OcclusionMode
from ssdo_gl.passes.draw_inputs import draw_inputs
from ssdo_gl.passes.edge_aware_filter import EdgeAwareFilterSettings
from ssdo_gl.passes.screen_space_settings import (
    ScreenSpaceSettings,
    defines,
    estimator_uniforms,
    kept_resources,
)
from ssdo_gl.settings.estimators import DEFAULT_ESTIMATOR, ESTIMATORS, described
from ssdo_gl.settings.fields import setting
from ssdo_gl.settings.methods import ALL, REFERENCES


@dataclass(frozen=True)
class SsaoSettings(ScreenSpaceSettings):
    """Settings of ambient visibility."""

    estimator: str = setting(
        DEFAULT_ESTIMATOR,
        described(ESTIMATORS),
        choices=tuple(ESTIMATORS),
    )
    box_px: float = setting(
        10.0, "zbuffer: half the width of the box around the pixel", unit="px", low=0.5, high=512.0
    )


def uniforms(settings: SsaoSettings, frame: Frame, has_back_layer: bool) -> dict[str, Any]:
    """Return the uniforms of `effects/ssao.frag`."""
    return {**estimator_uniforms(settings, frame, has_back_layer), "u_box_px": settings.box_px}


class SsaoPass(RenderPass):
    """Estimates (1/pi) * integral of V_R(w) cos(theta) dw at every receiver.

    Writes ``visibility_raw``: x = visibility in [0, 1], 1 = open; y = z of the receiver,
    for the filter. Background is open.

    Parameters
    ----------
    has_back_layer : bool
        Read ``z_layers`` to know where solids end.
    keeps : int or None
        Keep what blocks each direction, refined by so many bisections, for a bounce:
        ``kept_0``, ``kept_1``, ... (see ``screen_space/kept_directions.glsl``). None: do not.
    """

    overwrites: ClassVar[bool] = True

    def __init__(
        self,
        settings: SsaoSettings,
        *,
        has_back_layer: bool = False,
        keeps: int | None = None,
    ) -> None:
        self.name = "ssao"
        self.settings = settings
        back = ("z_layers",) if has_back_layer else ()
        self.reads = ("z_vs", "normals_vs", *back)
        spec = TextureSpec(2, scale=settings.resolution_scale, transient=True)
        self.writes = {"visibility_raw": spec}
        if keeps is not None:
            self.writes |= kept_resources(settings)
        self.depends_on = ("view", "seed")
        self._has_back_layer = has_back_layer
        self._defines = defines(
            settings,
            has_back_layer,
            keeps or 0,
            keeps_directions=keeps is not None,
        )

    def execute(self, context: PassContext) -> None:
        choices = ESTIMATORS[self.settings.estimator].choices
        program = context.shaders.fullscreen("effects/ssao.frag", self._defines, choices)
        values = uniforms(self.settings, context.frame, self._has_back_layer)
        draw_inputs(context, program, values, self.reads)


class ConstantVisibilityPass(RenderPass):
    """Writes `visibility`: 1, without looking at anything; it runs once."""

    name = "constant_visibility"
    writes: Mapping[str, TextureSpec] = {"visibility": TextureSpec(1)}

    def execute(self, context: PassContext) -> None:
        assert context.target is not None
        context.target.clear(1.0)


class Ssao(Effect):
    """Ambient visibility: multiplies light in the method ssao, and is an image in all others."""

    name = "ssao"
    after = ("directional",)
    methods = frozenset({"ssao"})
    shown_by = ALL - REFERENCES
    images = ("visibility",)
    shortcuts = (OPEN_DIRECTIONS,)
    settings: ClassVar[Mapping[str, type]] = {
        "ssao": SsaoSettings,
        "ssao_filter": EdgeAwareFilterSettings,
    }
    looks_around = True

    def is_asked(self, request: Request) -> bool:
        """Return whether visibility is asked for, and no other effect finds it on the way."""
        return super().is_asked(request) and not request.runs("directional")

    def need(self, request: Request) -> Decision:
        """Run where there is light for it to multiply, or where its image is wanted."""
        return need_of_visibility(request, multiplies_direct=True)

    def passes(self, request: Request) -> Iterator[ReasonedPass]:
        """Yield estimator and filter, or a constant where nothing can be blocked."""
        if request.takes(OPEN_DIRECTIONS):
            yield ConstantVisibilityPass(), "every visible point is open"
            return
        item = SsaoPass(
            estimator_settings(request, "ssao", SsaoSettings),
            has_back_layer=request.runs("back_layer"),
            keeps=request.kept_refinements,
        )
        yield item, "how open each point is"
        yield filtered(request, "ssao_filter", "visibility_raw", "visibility", is_visibility=True)

    def image(self, request: Request, name: str) -> ImageSource:
        return ImageSource("visibility", 1)

    def occlusion(self, request: Request) -> tuple[str, OcclusionMode]:
        """Return the visibility, and what it multiplies."""
        return "visibility", combine_of(request)

    def marches(self, request: Request) -> str:
        """Return the pass whose settings hold."""
        return "ssao"
