"""The full solution of light transport, by path tracing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

from ssdo_gl.effects.effect import Effect, ReasonedPass
from ssdo_gl.effects.request import Decision, Request
from ssdo_gl.graph.render_pass import PassContext
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.rays import RayPass, Schedule, SumOutput, emitters_of
from ssdo_gl.scene.environment import kind_of
from ssdo_gl.settings.fields import setting
from ssdo_gl.settings.settings import MAX_BOUNCES, same_as

# Paths of one draw and pixel: enough to spread the cost of finding the surface again.
MOST_PER_DRAW = 8
# Rays of a path that ends by chance, at most on average: 20 vertices in a white room,
# since none survives more surely than 0.95, and two rays from each.
RAYS_PER_PATH = 40


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


class ReferenceGiPass(RayPass):
    """Writes `gi_radiance`: what the camera sees, all bounces; a = coverage.

    Emission of what the camera sees, and the sky behind it, are included: it is the
    picture. Emissive meshes shine triangle by triangle, whatever lights stand for them.
    """

    name = "reference_gi"
    writes: Mapping[str, TextureSpec] = {"gi_radiance": TextureSpec(4, "f4")}
    depends_on = ("view", "geometry", "lights", "environment", "seed")
    outputs = (SumOutput("gi_radiance", channels=3),)
    label = "path tracing"
    surface = ("z_vs", "normals_vs", "albedo", "emission")
    reflects = True

    def defines(self, context: PassContext) -> dict[str, int]:
        """Add whether any surface or lamp emits."""
        return {
            **super().defines(context),
            "HAS_EMITTERS": int(emitters_of(context).group_count > 0),
        }

    def uniforms(self, context: PassContext) -> dict[str, object]:
        """Add how long paths are."""
        return {**super().uniforms(context), **uniforms(self.settings)}

    def schedule(self, context: PassContext) -> Schedule:
        bounces = self.settings.bounces
        rays_per_path = RAYS_PER_PATH if bounces is None else 2 * (bounces + 1)
        return Schedule(self.settings.spp, rays_per_path, MOST_PER_DRAW, self.settings.max_error)


class ReferenceGi(Effect):
    """All light transport, path traced: it is the whole picture."""

    name = "reference_gi"
    after = ("reflections",)
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
        settings = request.settings_of(self.name, ReferenceGiSettings)
        item = ReferenceGiPass(settings, request.ray_features, kind_of(request.scene.environment))
        yield item, "all light transport, by paths"
