"""Direct light with shadows by rays instead of shadow maps."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from ssdo_gl.effects.decisions import Decision
from ssdo_gl.effects.effect import Effect, ReasonedPass, Term
from ssdo_gl.effects.methods import ALL
from ssdo_gl.effects.request import Request
from ssdo_gl.effects.scene_lights import need_of_direct_light
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.accumulate import Schedule, SumOutput, accumulate
from ssdo_gl.passes.environment_uniforms import environment_uniforms
from ssdo_gl.passes.ray_uniforms import (
    EMITTER_TABLES,
    ray_defines,
    ray_reads,
    ray_uniforms,
)
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.settings.settings import same_as

# Rays to each light of one draw and pixel.
MOST_PER_DRAW = 16
OUTPUT = SumOutput("direct_irradiance", channels=3)


@dataclass(frozen=True)
class TracedShadowsSettings:
    """Settings of direct light with traced shadows."""

    shadow_rays: int = same_as("shadow_rays")
    max_error: float | None = same_as("max_error")


class TracedShadowsPass(RenderPass):
    """Writes `direct_irradiance`: rgb irradiance of all lights but ``ssdo`` ones.

    Unbiased: each ray goes to a random point of a light. Exactly 0 where none arrives.

    Parameters
    ----------
    settings : TracedShadowsSettings
    features : RayFeatures
        Of the scene: `RayFeatures.of`.
    """

    name = "traced_shadows"
    writes: Mapping[str, TextureSpec] = {"direct_irradiance": TextureSpec(4, "f4")}
    depends_on = ("view", "geometry", "lights", "seed")

    def __init__(self, settings: TracedShadowsSettings, features: RayFeatures) -> None:
        self.settings = settings
        self.features = features
        self.reads = ("z_vs", "normals_vs", *ray_reads(features, shades=True), *EMITTER_TABLES)
        self.statistics: Mapping[str, Any] = {}

    def settings_key(self) -> Hashable:
        """Return the settings and the features."""
        return self.settings, self.features

    def execute(self, context: PassContext) -> None:
        """Trace all rays, draw after draw."""
        inputs, frame = context.inputs, context.frame
        # The environment is no light of `direct`: the shader needs none.
        defines = {**ray_defines(context, self.features), "ENVIRONMENT_KIND": 0}
        settings = self.settings
        self.statistics = accumulate(
            context,
            context.shaders.fullscreen("effects/traced_shadows.frag", defines),
            {**ray_uniforms(context), **environment_uniforms(frame)},
            {f"t_{name}": inputs[name] for name in self.reads},
            [OUTPUT],
            Schedule(
                settings.shadow_rays,
                max(1, len(frame.scene.lights)),
                MOST_PER_DRAW,
                settings.max_error,
            ),
            "traced shadows",
        )


class TracedShadows(Effect):
    """Light of the scene's lights, shadowed by rays."""

    name = "traced_shadows"
    methods = ALL - {"reference-gi"}
    shown_by = ALL
    terms = (Term("direct", "direct_irradiance"),)
    settings: ClassVar[Mapping[str, type]] = {"traced_shadows": TracedShadowsSettings}
    traces = True

    def is_asked(self, request: Request) -> bool:
        """Return whether shadows are traced; else another effect has this light."""
        return super().is_asked(request) and request.settings.chosen_shadows == "traced"

    def need(self, request: Request) -> Decision:
        """Run where any light can light what is in view."""
        return need_of_direct_light(request)

    def passes(self, request: Request) -> Iterator[ReasonedPass]:
        """Yield the one pass."""
        chosen = request.settings
        base = TracedShadowsSettings(chosen.shadow_rays, chosen.max_error)
        settings = request.with_overrides(self.name, base)
        item = TracedShadowsPass(settings, RayFeatures.of(request.scene))
        yield item, "light of the scene's lights, by shadow rays"
