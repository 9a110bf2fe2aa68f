"""Light from beyond R: a final gather by screen probes and per-pixel rays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import ClassVar

import moderngl

from ssdo_gl.effects.effect import Effect, ReasonedPass
from ssdo_gl.effects.gathered_light import GatheredLightPass
from ssdo_gl.effects.near_field import far_field_settings, receiver_stride
from ssdo_gl.effects.own_rays import OwnRaysPass
from ssdo_gl.effects.request import Decision, Request
from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.graph.render_pass import PassContext, Produced, RenderPass, TextureWithFacts
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.far_probes import (
    FAR_POINTS,
    FAR_RADIANCE,
    FarFieldSettings,
    ProbeRays,
    tile_count,
)
from ssdo_gl.passes.own_textures import facts_of, fill, textures_of
from ssdo_gl.passes.rays import (
    radius_ns,
    ray_defines,
    ray_reads,
    ray_uniforms,
    stream_of,
)
from ssdo_gl.passes.surfels import BrightTablesPass, cache_tables
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.scene.environment import kind_of
from ssdo_gl.scene.lights import Form

SURFACES = ("z_vs", "normals_vs")


class FarProbesPass(RenderPass):
    """Writes where probes stand, and `far_radiance`: what they see beyond R, by direction.

    All frames of a steady view share it. In a live frame that has moved, or whose light is
    still spreading, there are none.
    """

    name = "far_probes"
    writes: Mapping[str, TextureSpec] = {
        name: TextureSpec(4, "f4", own=True) for name in (FAR_POINTS, FAR_RADIANCE)
    }
    is_gradual = True
    lags = False

    def __init__(
        self,
        settings: FarFieldSettings,
        features: RayFeatures,
        *,
        is_steady: bool,
    ) -> None:
        self.settings = settings
        self.features = features
        self.is_steady = is_steady
        self.reads = (*SURFACES, *ray_reads(features, shades=True), *cache_tables(features))
        self.steady_reads = SURFACES if is_steady else ()
        self._of_view = ("steady_view" if is_steady else "view", "geometry")
        self.depends_on = (*self._of_view, "steady_seed" if is_steady else "seed")

    def execute(self, context: PassContext) -> Produced:
        """Trace one ray for each direction of all probes, or none."""
        frame = context.frame
        changed = frame.versions.get("geometry"), frame.versions.get("materials")
        view = tuple(frame.versions.get(domain) for domain in self._of_view)
        source = view, self.settings_key(), frame.versions.get("steady_seed")
        rays = ProbeRays(source, (context.inputs["surface_cache"], changed))
        known = facts_of(context, FAR_RADIANCE, ProbeRays)
        is_of_light = known is not None and known.light == rays.light
        if frame.is_live and (frame.moves > 0 or not context.is_complete):
            points = radiance = make_texture(context.gl, (1, 1), 4, "f4", 4 * [0.0])
            is_brief = not (context.is_complete and (is_of_light or known is None))
            rays = replace(rays, gives_way=True, is_brief=is_brief)
        elif known is not None and is_of_light and known.source == source and not known.gives_way:
            points, radiance = (context.last[n].texture for n in (FAR_POINTS, FAR_RADIANCE))
            rays = known
        else:
            points, radiance = self._traced(context)
        return {FAR_POINTS: points, FAR_RADIANCE: TextureWithFacts(radiance, rays)}

    def _traced(self, context: PassContext) -> tuple[moderngl.Texture, moderngl.Texture]:
        """Return where probes stand and what they see."""
        frame, gl = context.frame, context.gl
        tiles = tile_count(frame.view.size, self.settings.tile)
        points = make_texture(gl, (tiles[0], 2 * tiles[1]), 4, "f4")
        defines = {"PROBE_TILE": self.settings.tile, "PROBE_SIDE": self.settings.directions}
        surfaces, uniforms = textures_of(context, SURFACES), frame.view.uniforms()
        fill(context, [points], "effects/far_probe_points.frag", defines, uniforms, surfaces)
        radiance = make_texture(gl, self.settings.map_size(tiles), 4, "f4")
        defines = {**ray_defines(context, self.features), "PROBE_SIDE": self.settings.directions}
        seed = frame.first_seed if self.is_steady else frame.seed
        uniforms = {
            **ray_uniforms(context),
            "u_radius_ns": radius_ns(self.settings.radius, context),
            "u_stream": stream_of(seed + (frame.moves << 32), 0),
        }
        textures = {**textures_of(context, self.reads), "t_far_probe_points": points}
        fill(context, [radiance], "effects/far_probes.frag", defines, uniforms, textures)
        return points, radiance


class CachedIrradiancePass(RenderPass):
    """Writes `cached_irradiance`: what surfaces in view receive, all light."""

    name = "cached_irradiance"
    writes: Mapping[str, TextureSpec] = {"cached_irradiance": TextureSpec(4, "f4", own=True)}

    def __init__(self, features: RayFeatures, *, is_steady: bool) -> None:
        self.features = features
        self.reads = ("z_vs", *ray_reads(features, shades=True), *cache_tables(features))
        self.steady_reads = ("z_vs",) if is_steady else ()
        self.depends_on = ("steady_view" if is_steady else "view", "geometry")

    def execute(self, context: PassContext) -> dict[str, moderngl.Texture]:
        """Look up every pixel's piece of surface."""
        made = make_texture(context.gl, context.frame.view.size, 4, "f4")
        defines, uniforms = ray_defines(context, self.features), ray_uniforms(context)
        textures = textures_of(context, self.reads)
        fill(context, [made], "effects/cached_irradiance.frag", defines, uniforms, textures)
        return {self.name: made}


class FarField(Effect):
    """Light from beyond R, and with it all light transport."""

    name = "far_field"
    after = ("emitters",)
    # As decisions call it.
    title = "far field"
    methods = frozenset({"gi"})
    settings: ClassVar[Mapping[str, type]] = {"far_field": FarFieldSettings}
    traces = True
    reads_surface_cache = True
    sent_irradiance = "cached_irradiance"

    def is_asked(self, request: Request) -> bool:
        """Return whether open directions are asked for."""
        return request.settings.method in self.methods and "directional" in request.asked

    def need(self, request: Request) -> Decision:
        """Run where any light can come from beyond R, by way of the scene."""
        content = request.content
        is_lit = content.environment != "none" or content.has_lights or content.has_unlit_emission
        return request.decision(
            self.title,
            "light comes from beyond R, and bounces on",
            [
                (request.is_view_empty, "no surface is in view"),
                (not content.has_albedo, "every surface is black, nothing is sent on"),
                (not is_lit, "there is no light at all"),
                (self._is_alone(request), "what is in view is a box that stands alone"),
            ],
            ("far_probes", "own_rays", "gathered_light", "cached_irradiance"),
        )

    def _is_alone(self, request: Request) -> bool:
        """Return whether nothing in the scene stands above any visible tangent plane.

        A frame of a lone textured box (a model made by others) takes .43 of the time.
        """
        if request.view is None or not request.view.is_alone:
            return False
        # Lamps stand before the sky, too.
        lamps = any(light.form is Form.AREA for light in request.scene.lights)
        return len(request.scene.objects) == 1 and not lamps

    def passes(self, request: Request) -> Iterator[ReasonedPass]:
        """Yield where probes stand, and what they see."""
        settings = far_field_settings(request)
        # What is translucent is another surface in each frame.
        is_steady = not request.content.has_translucency
        if settings.aimed_rays:
            yield BrightTablesPass(), "what is so bright that rays are aimed at it"
        features = replace(request.cache_features, glow_is_direct=request.runs("emitters"))
        sky = kind_of(request.scene.environment)
        item = FarProbesPass(settings, features, is_steady=is_steady)
        yield item, "radiance from beyond R, at probes"
        stride = receiver_stride(request)
        own = OwnRaysPass(settings, features, sky, stride, is_steady=is_steady)
        yield own, "light gathered by per-pixel rays"
        yield GatheredLightPass(settings, features, sky, stride), "their light in this frame"
        cached = CachedIrradiancePass(features, is_steady=is_steady)
        yield cached, "what reflected surfaces receive, all bounces"
