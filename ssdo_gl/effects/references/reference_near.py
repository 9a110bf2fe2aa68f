"""Directional light and one bounce with ray-traced visibility: the reference of SSDO."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

from ssdo_gl.effects.effect import Effect, ReasonedPass, Term
from ssdo_gl.effects.request import Decision, Request
from ssdo_gl.graph.render_pass import PassContext
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.rays import RayPass, Schedule, SumOutput, asked_lights, radius_ns
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.scene.environment import EnvironmentKind, kind_of
from ssdo_gl.settings.methods import REFERENCES
from ssdo_gl.settings.settings import same_as

# Samples of one draw and pixel; each takes a ray, and from what it hits one to each light.
MOST_PER_DRAW = 16


@dataclass(frozen=True)
class ReferenceNearSettings:
    """Settings of the ray-traced near field."""

    radius: float = same_as("radius", 0.3)
    spp: int = same_as("spp")
    max_error: float | None = same_as("max_error")


class ReferenceNearPass(RayPass):
    """Writes `directional_irradiance` (a = visibility) and `bounce_irradiance`.

    Where the scene has gloss it writes `near_gloss`, too: rgb radiance that glossy surfaces
    reflect of the sky, and of what surfaces at any distance send.

    Unbiased estimates of the integrals that ``effects/reference_near.frag`` states.
    """

    name = "reference_near"
    depends_on = ("view", "geometry", "lights", "environment", "seed")
    label = "ray-traced near field"
    reflects = True

    def __init__(
        self,
        settings: ReferenceNearSettings,
        features: RayFeatures,
        environment: EnvironmentKind = "none",
    ) -> None:
        super().__init__(settings, features, environment)
        names = ["directional_irradiance", "bounce_irradiance"]
        names += ["near_gloss"] if features.glossy else []
        self.writes = {name: TextureSpec(4, "f4") for name in names}
        self.outputs = tuple(SumOutput(name, 3) for name in names)

    def uniforms(self, context: PassContext) -> dict[str, object]:
        return {
            **super().uniforms(context),
            "u_radius_ns": radius_ns(self.settings.radius, context),
        }

    def schedule(self, context: PassContext) -> Schedule:
        # A ray, where it hits one to each light that is asked and one to the sky, and those of
        # the lights that arrive through the receiver's own open directions.
        rays_per_sample = 2 + 2 * asked_lights(len(context.frame.scene.lights))
        return Schedule(self.settings.spp, rays_per_sample, MOST_PER_DRAW, self.settings.max_error)


class ReferenceNear(Effect):
    """Directional light and one bounce by rays."""

    name = "reference_near"
    after = ("reflections",)
    methods = frozenset({"reference-near"})
    shown_by = REFERENCES
    terms = (
        Term("directional", "directional_irradiance"),
        Term("bounce", "bounce_irradiance"),
        Term("specular", "near_gloss", "radiance", glossy=True),
    )
    settings: ClassVar[Mapping[str, type]] = {"reference_near": ReferenceNearSettings}
    traces = True

    def need(self, request: Request) -> Decision:
        """Run where any light arrives from directions or is sent on."""
        content = request.content
        by_direction = content.environment != "none" or content.has_ssdo_lights
        is_lit = by_direction or content.has_lights or content.has_unlit_emission
        return request.decision(
            "near field",
            "light arrives from all directions, or is sent on by what blocks them",
            [
                (not is_lit, "there is no light at all"),
                (
                    not (by_direction or content.has_albedo),
                    "no light comes by direction, and every surface is black",
                ),
            ],
            ("reference_near", "directional_radiance", "bounce_radiance"),
        )

    def passes(self, request: Request) -> Iterator[ReasonedPass]:
        """Yield the one pass."""
        settings = request.settings_of(self.name, ReferenceNearSettings)
        item = ReferenceNearPass(settings, request.ray_features, kind_of(request.scene.environment))
        yield item, "the near field, by rays"
