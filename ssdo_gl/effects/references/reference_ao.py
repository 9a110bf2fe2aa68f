"""Ray-traced ambient visibility: the reference for every estimator of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

from ssdo_gl.effects.ambient import combine_of, need_of_visibility
from ssdo_gl.effects.effect import Effect, ImageSource, ReasonedPass
from ssdo_gl.effects.request import Decision, Request
from ssdo_gl.graph.render_pass import PassContext
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.composite import OcclusionMode
from ssdo_gl.passes.rays import RayPass, Schedule, SumOutput, radius_ns
from ssdo_gl.settings.methods import REFERENCES
from ssdo_gl.settings.settings import same_as

# Rays of one draw and pixel: enough to spread the cost of finding the surface again.
MOST_PER_DRAW = 32


@dataclass(frozen=True)
class ReferenceAoSettings:
    """Settings of ray-traced visibility."""

    radius: float = same_as("radius", 0.3)
    spp: int = same_as("spp")
    max_error: float | None = same_as("max_error")


class ReferenceAoPass(RayPass):
    """Writes `visibility`: (1 / pi) integral of V_R(w) cos over the hemisphere, by rays.

    Cosine-weighted about the shading normal; 1 = open; 1 where there is no surface.
    """

    name = "reference_ao"
    writes: Mapping[str, TextureSpec] = {"visibility": TextureSpec(1, "f4")}
    depends_on = ("view", "geometry", "seed")
    outputs = (SumOutput("visibility", channels=1),)
    label = "ray-traced visibility"
    gathers_light = False

    def uniforms(self, context: PassContext) -> dict[str, object]:
        return {
            **super().uniforms(context),
            "u_radius_ns": radius_ns(self.settings.radius, context),
        }

    def schedule(self, context: PassContext) -> Schedule:
        return Schedule(self.settings.spp, 1, MOST_PER_DRAW, self.settings.max_error)


class ReferenceAo(Effect):
    """Ambient visibility by rays."""

    name = "reference_ao"
    after = ("reflections",)
    methods = frozenset({"reference-ao"})
    shown_by = REFERENCES
    images = ("visibility",)
    settings: ClassVar[Mapping[str, type]] = {"reference_ao": ReferenceAoSettings}
    traces = True

    def need(self, request: Request) -> Decision:
        """Run where there is light for it to multiply, or where its image is wanted."""
        return need_of_visibility(request, multiplies_direct=False)

    def passes(self, request: Request) -> Iterator[ReasonedPass]:
        """Yield the one pass."""
        settings = request.settings_of(self.name, ReferenceAoSettings)
        yield ReferenceAoPass(settings, request.ray_features), "how open each point is"

    def image(self, request: Request, name: str) -> ImageSource:
        return ImageSource("visibility", 1)

    def occlusion(self, request: Request) -> tuple[str, OcclusionMode]:
        """Return the visibility; the report adds it as a light of its own."""
        combine = combine_of(request)
        return "visibility", "report_traced" if combine == "report" else combine
