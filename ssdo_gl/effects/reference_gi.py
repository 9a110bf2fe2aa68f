"""The full solution of light transport, by path tracing."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from ssdo_gl.effects.decisions import Decision
from ssdo_gl.effects.effect import Effect, ReasonedPass
from ssdo_gl.effects.request import Request
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.accumulate import Schedule, SumOutput, accumulate
from ssdo_gl.passes.environment_uniforms import (
    MAP_RADIANCE,
    environment_kind,
    environment_uniforms,
)
from ssdo_gl.passes.ray_uniforms import (
    EMITTER_TABLES,
    emitters_of,
    ray_defines,
    ray_reads,
    ray_uniforms,
)
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.scene.environment_kinds import Environment
from ssdo_gl.settings.fields import setting
from ssdo_gl.settings.settings import MAX_BOUNCES, same_as

# Paths of one draw and pixel: enough to spread the cost of finding the surface again.
MOST_PER_DRAW = 8
# Rays of a path that ends by chance, at most on average: 20 vertices in a white room,
# since none survives more surely than 0.95, and two rays from each.
RAYS_PER_PATH = 40
OUTPUT = SumOutput("gi_radiance", channels=3)


@dataclass(frozen=True)
class ReferenceGiSettings:
    """Settings of the path tracer."""

    spp: int = same_as("spp")
    bounces: int | None = same_as("bounces")
    roulette_start: int = setting(
        2, "bounces that every path makes before it may end by chance", low=0, high=64
    )
    max_error: float | None = same_as("max_error")


def uniforms(settings: ReferenceGiSettings) -> dict[str, object]:
    """Return the uniforms that say how long the paths of ``effects/reference_gi.frag`` are."""
    limited = settings.bounces is not None
    return {
        "u_max_bounces": settings.bounces if limited else MAX_BOUNCES,
        # A fixed number of bounces is not shortened by chance.
        "u_roulette_start": MAX_BOUNCES if limited else settings.roulette_start,
    }


class ReferenceGiPass(RenderPass):
    """Writes `gi_radiance`: what the camera sees, all bounces; a = coverage.

    Emission of what the camera sees, and the sky behind it, are included: it is the
    picture. Emissive meshes shine triangle by triangle, whatever lights stand for them.

    Parameters
    ----------
    settings : ReferenceGiSettings
    features : RayFeatures
        Of the scene: `RayFeatures.of`.
    environment : Environment or None
        Of the scene: decides how the sky is looked up.
    """

    name = "reference_gi"
    writes: Mapping[str, TextureSpec] = {"gi_radiance": TextureSpec(4, "f4")}
    depends_on = ("view", "geometry", "lights", "environment", "seed")

    def __init__(
        self,
        settings: ReferenceGiSettings,
        features: RayFeatures,
        environment: Environment | None,
    ) -> None:
        self.settings = settings
        self.features = features
        self.environment_kind = environment_kind(environment)
        self.reads = (
            "z_vs",
            "normals_vs",
            "albedo",
            "emission",
            *ray_reads(features, shades=True),
            *EMITTER_TABLES,
            *((MAP_RADIANCE,) if self.environment_kind == 3 else ()),
        )
        self.statistics: Mapping[str, Any] = {}

    def settings_key(self) -> Hashable:
        """Return the settings, the features and the kind of sky."""
        return self.settings, self.features, self.environment_kind

    def execute(self, context: PassContext) -> None:
        """Trace all paths, draw after draw."""
        inputs, frame = context.inputs, context.frame
        defines = ray_defines(context, self.features)
        defines["ENVIRONMENT_KIND"] = self.environment_kind
        defines["HAS_EMITTERS"] = int(emitters_of(context).group_count > 0)
        bounces = self.settings.bounces
        rays_per_path = RAYS_PER_PATH if bounces is None else 2 * (bounces + 1)
        self.statistics = accumulate(
            context,
            context.shaders.fullscreen("effects/reference_gi.frag", defines),
            {
                **ray_uniforms(context),
                **environment_uniforms(frame),
                **uniforms(self.settings),
            },
            {f"t_{name}": inputs[name] for name in self.reads},
            [OUTPUT],
            Schedule(self.settings.spp, rays_per_path, MOST_PER_DRAW, self.settings.max_error),
            "path tracing",
        )


class ReferenceGi(Effect):
    """All light transport, path traced: it is the whole picture."""

    name = "reference_gi"
    methods = frozenset({"reference-gi"})
    settings: ClassVar[Mapping[str, type]] = {"reference_gi": ReferenceGiSettings}
    picture = "gi_radiance"
    traces = True

    def need(self, request: Request) -> Decision:
        """Run whenever the picture is asked for."""
        reason = "all light transport was asked for"
        return Decision("path tracing", True, reason, ("reference_gi",))

    def passes(self, request: Request) -> Iterator[ReasonedPass]:
        """Yield the one pass."""
        chosen = request.settings
        base = ReferenceGiSettings(chosen.spp, chosen.bounces, max_error=chosen.max_error)
        settings = request.with_overrides(self.name, base)
        features = RayFeatures.of(request.scene)
        item = ReferenceGiPass(settings, features, request.environment)
        yield item, "all light transport, by paths"
