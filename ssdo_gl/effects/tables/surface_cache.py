"""The surface cache: irradiance of the whole scene, kept on its surfaces."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import ClassVar

from ssdo_gl.effects.effect import Effect, ReasonedPass
from ssdo_gl.effects.request import Decision, Request
from ssdo_gl.passes.surfels import (
    SurfaceCachePass,
    SurfaceCacheSettings,
    SurfelDirectPass,
    SurfelRaysPass,
    SurfelSkyPass,
    SurfelsPass,
)
from ssdo_gl.scene.environment import kind_of


class SurfaceCache(Effect):
    """Irradiance of all surfaces by all light, whatever the view shows of them."""

    name = "surface_cache"
    settings: ClassVar[Mapping[str, type]] = {"surface_cache": SurfaceCacheSettings}
    traces = True

    def is_asked(self, request: Request) -> bool:
        """Return whether an effect that runs looks light up on surfaces."""
        return request.reads_surface_cache

    def need(self, request: Request) -> Decision:
        """Run whenever another effect asks for it."""
        passes = ("surfels", "surfel_rays", "surfel_sky", "surfel_direct", "surface_cache")
        return Decision("surface cache", True, "light is looked up where rays end", passes)

    def passes(self, request: Request) -> Iterator[ReasonedPass]:
        """Yield what is done once for the geometry, once for the lights, and the bounces."""
        settings = request.settings_of(self.name, SurfaceCacheSettings)
        features, sky = request.cache_features, kind_of(request.scene.environment)
        yield SurfelsPass(settings, features), "pieces of surface that keep light"
        yield SurfelRaysPass(settings, features), "what each piece sees of the others"
        yield SurfelSkyPass(settings, features, sky), "the sky that each piece sees"
        lit = replace(features, glow_is_direct=request.runs("emitters"))
        yield SurfelDirectPass(settings, lit, sky), "light straight from its sources"
        yield SurfaceCachePass(settings, features), "all bounces between the pieces"
