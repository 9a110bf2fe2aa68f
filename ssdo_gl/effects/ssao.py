"""Ambient visibility from the depth buffer."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar

from ssdo_gl.effects.ambient import combine_of, need_of_visibility
from ssdo_gl.effects.decisions import Decision
from ssdo_gl.effects.effect import Effect, ImageSource, ReasonedPass
from ssdo_gl.effects.methods import ALL, REFERENCES
from ssdo_gl.effects.near_field import OPEN_DIRECTIONS, estimator_settings, filtered
from ssdo_gl.effects.request import Request
from ssdo_gl.passes.ambient_visibility import ConstantVisibilityPass, SsaoPass, SsaoSettings
from ssdo_gl.passes.composite import OcclusionMode
from ssdo_gl.passes.edge_aware_filter import EdgeAwareFilterSettings


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
