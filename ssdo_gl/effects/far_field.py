"""Light from beyond R, for every open direction: probes on what is in view, fed by rays."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Mapping
from typing import Any, ClassVar

import moderngl

from ssdo_gl.effects.decisions import Decision
from ssdo_gl.effects.effect import Effect, ReasonedPass
from ssdo_gl.effects.request import Request
from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.texture import make_framebuffer, make_texture
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.far_probes import FAR_PROBES, FAR_RADIANCE, NEAR_HITS, FarFieldSettings
from ssdo_gl.passes.ray_uniforms import (
    radius_ns,
    ray_defines,
    ray_reads,
    ray_uniforms,
    stream_of,
)
from ssdo_gl.passes.surfel_textures import CACHE_TABLES
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.scene.lights import Form


def tile_count(frame_size: tuple[int, int], tile: int) -> tuple[int, int]:
    """Return columns and rows of probe images: first probes, and above them second ones."""
    columns, rows = (-(-n // tile) for n in frame_size)
    return columns, 2 * rows


class FarProbePointsPass(RenderPass):
    """Writes where the probes stand: `far_probe_points` and `far_probe_normals`."""

    name = "far_probe_points"
    reads = ("z_vs", "normals_vs")
    writes: Mapping[str, TextureSpec] = {n: TextureSpec(4, "f4", own=True) for n in FAR_PROBES}
    depends_on = ("view",)

    def __init__(self, settings: FarFieldSettings) -> None:
        self.settings = settings

    def execute(self, context: PassContext) -> dict[str, moderngl.Texture]:
        """Choose a pixel of each tile, and a second one where it shows two surfaces."""
        size = tile_count(context.frame.view.size, self.settings.tile)
        made = {name: make_texture(context.gl, size, 4, "f4") for name in FAR_PROBES}
        _draw(
            context,
            "effects/far_probe_points.frag",
            {"PROBE_TILE": self.settings.tile},
            context.frame.view.uniforms(),
            self.reads,
            list(made.values()),
        )
        return made


class FarProbesPass(RenderPass):
    """Writes `far_radiance`: what arrives from beyond R along each direction of each probe."""

    name = "far_probes"
    writes: Mapping[str, TextureSpec] = {FAR_RADIANCE: TextureSpec(4, "f4", own=True)}
    depends_on = ("view", "geometry", "seed")

    def __init__(self, settings: FarFieldSettings, features: RayFeatures) -> None:
        self.settings = settings
        self.features = features
        self.reads = (
            *FAR_PROBES,
            "z_vs",
            *ray_reads(features, shades=True),
            *CACHE_TABLES,
        )

    def settings_key(self) -> Hashable:
        """Return the settings and the features."""
        return self.settings, self.features

    def execute(self, context: PassContext) -> dict[str, moderngl.Texture]:
        """Trace one ray for each direction of each probe."""
        chosen = self.settings
        columns, rows = tile_count(context.frame.view.size, chosen.tile)
        size = columns * chosen.directions, rows * chosen.directions
        made = make_texture(context.gl, size, 4, "f4")
        defines = {
            **ray_defines(context, self.features),
            "PROBE_SIDE": chosen.directions,
            "NEAR_HITS": NEAR_HITS.index(chosen.near_hits),
        }
        uniforms = {
            **ray_uniforms(context),
            "u_radius_ns": radius_ns(chosen.radius, context),
            "u_stream": stream_of(context.frame.seed, 0),
        }
        _draw(context, "effects/far_probes.frag", defines, uniforms, self.reads, [made])
        return {FAR_RADIANCE: made}


def _draw(
    context: PassContext,
    shader: str,
    defines: Mapping[str, int],
    uniforms: Mapping[str, Any],
    reads: tuple[str, ...],
    textures: list[moderngl.Texture],
) -> None:
    """Draw into textures of the pass' own."""
    target = make_framebuffer(context.gl, textures)
    inputs = {f"t_{name}": context.inputs[name] for name in reads}
    draw_fullscreen(
        context.gl, context.shaders.fullscreen(shader, defines), target, uniforms, inputs
    )
    target.release()


class CachedIrradiancePass(RenderPass):
    """Writes `cached_irradiance`: what surfaces in view receive, all light, for senders."""

    name = "cached_irradiance"
    writes: Mapping[str, TextureSpec] = {"cached_irradiance": TextureSpec(4, "f4")}
    depends_on = ("view", "geometry")

    def __init__(self, features: RayFeatures) -> None:
        self.features = features
        self.reads = ("z_vs", *ray_reads(features, shades=True), *CACHE_TABLES)

    def settings_key(self) -> Hashable:
        """Return the features."""
        return self.features

    def execute(self, context: PassContext) -> None:
        """Look up every pixel's piece of surface."""
        assert context.target is not None
        draw_fullscreen(
            context.gl,
            context.shaders.fullscreen(
                "effects/cached_irradiance.frag", ray_defines(context, self.features)
            ),
            context.target,
            ray_uniforms(context),
            {f"t_{name}": context.inputs[name] for name in self.reads},
        )


class FarField(Effect):
    """What arrives from beyond R, and with it all of the light."""

    name = "far_field"
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
                (self._is_alone(request), "what is in view is a box or a sheet that stands alone"),
            ],
            ("far_probe_points", "far_probes", "cached_irradiance"),
        )

    def _is_alone(self, request: Request) -> bool:
        """Return whether nothing in the scene stands above any visible tangent plane."""
        view = request.view
        if view is None or view.open_distance < math.inf:
            return False
        # Lamps stand before the sky, too.
        lamps = any(light.form is Form.AREA for light in request.scene.lights)
        return len(request.scene.objects) == 1 and not lamps

    def passes(self, request: Request) -> Iterator[ReasonedPass]:
        """Yield where probes stand, and what they see."""
        settings = request.with_overrides(self.name, FarFieldSettings(radius=request.radius))
        yield FarProbePointsPass(settings), "a probe for each tile of what is in view"
        features = request.ray_features
        item = FarProbesPass(settings, features)
        yield item, "what arrives from beyond R"
        yield CachedIrradiancePass(features), "what senders within R receive, all bounces"
