"""Direct light with shadows by rays instead of shadow maps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

from ssdo_gl.effects.effect import Effect, ReasonedPass, Term
from ssdo_gl.effects.request import Decision, Request
from ssdo_gl.effects.scene_lights import need_of_direct_light
from ssdo_gl.graph.render_pass import PassContext
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.last_made import LastMade
from ssdo_gl.passes.rays import RayPass, Schedule, SumOutput, asked_lights
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.settings.methods import ALL
from ssdo_gl.settings.settings import same_as

# Rays to each light of one draw and pixel.
MOST_PER_DRAW = 16


@dataclass(frozen=True)
class TracedShadowsSettings:
    """Settings of direct light with traced shadows."""

    shadow_rays: int = same_as("shadow_rays")
    max_error: float | None = same_as("max_error")


class TracedShadowsPass(RayPass):
    """Writes `direct_irradiance`: rgb irradiance of all lights but ``ssdo`` ones.

    Unbiased: each ray goes to a random point of a light. Exactly 0 where none arrives.
    Where `features` has gloss it writes `direct_gloss`, too: rgb radiance that glossy
    surfaces reflect to the camera.
    """

    name = "traced_shadows"
    depends_on = ("view", "geometry", "lights", "seed")
    label = "traced shadows"
    reflects = True

    def __init__(self, settings: TracedShadowsSettings, features: RayFeatures) -> None:
        super().__init__(settings, features)
        names = ("direct_irradiance", *(("direct_gloss",) if features.glossy else ()))
        self.writes = {name: TextureSpec(4, "f4") for name in names}
        self.outputs = tuple(SumOutput(name, channels=3) for name in names)
        self._bodies: LastMade[bool] = LastMade()

    def defines(self, context: PassContext) -> dict[str, int]:
        """Add whether lobes can meet a light."""
        objects = context.frame.scene.objects
        bodies = self._bodies.get((objects,), lambda: any(o.light is not None for o in objects))
        return {**super().defines(context), "LOBES_MEET_LIGHTS": int(bodies)}

    def schedule(self, context: PassContext) -> Schedule:
        """Return the schedule of samples, each a ray to every light that is asked."""
        rays_per_sample = max(1, asked_lights(len(context.frame.scene.lights)))
        return Schedule(
            self.settings.shadow_rays, rays_per_sample, MOST_PER_DRAW, self.settings.max_error
        )


class TracedShadows(Effect):
    """Light of the scene's lights, shadowed by rays."""

    name = "traced_shadows"
    after = ("direct",)
    methods = ALL - {"reference-gi"}
    shown_by = ALL
    terms = (
        Term("direct", "direct_irradiance"),
        Term("specular", "direct_gloss", "radiance", glossy=True),
    )
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
        settings = request.settings_of(self.name, TracedShadowsSettings)
        # Only what is in view reflects here; what shadow rays meet does not.
        features = replace(request.ray_features, glossy=request.is_glossy)
        item = TracedShadowsPass(settings, features)
        yield item, "light of the scene's lights, by shadow rays"
