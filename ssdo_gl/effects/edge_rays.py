"""Rays of their own for the pixels that a neighbour in front may shade."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.texture import make_framebuffer, make_texture
from ssdo_gl.graph.render_pass import PassContext, Produced, RenderPass, TextureWithFacts
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.edge_lookup import EDGE_RAYS, EdgeRays
from ssdo_gl.passes.environment_uniforms import MAP_RADIANCE, environment_uniforms
from ssdo_gl.passes.far_probes import FAR_RADIANCE, FarFieldSettings, ProbeRays, refining_parts
from ssdo_gl.passes.rays import radius_ns, ray_defines, ray_reads, ray_uniforms, stream_of
from ssdo_gl.passes.surfels import CACHE_TABLES, facts_of, textures_of
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.scene.environment import ENVIRONMENT_KINDS, EnvironmentKind

# Of textures with a texel for each such pixel: so many to a row, more where rows would be more
# than any device has.
PIXELS_PER_ROW, MOST_ROWS = 256, 8192


def places_of(
    chosen: NDArray[np.integer[Any]], size: tuple[int, int]
) -> tuple[NDArray[np.float32], ...]:
    """Return where pixels have a texel of their own, and which pixel each texel stands for.

    Parameters
    ----------
    chosen : (n,) integers
        Of the frame's pixels, row by row.
    size : (int, int)
        Width and height of the frame, pixels.

    Returns
    -------
    (height, width, 1) float32
        One more than the texel's number; 0: the pixel has none.
    (rows, columns, 2) float32
        Column and row of the pixel; -1: none.
    """
    places = np.zeros((size[1], size[0], 1), np.float32)
    places.flat[chosen] = np.arange(1, len(chosen) + 1)
    columns = max(PIXELS_PER_ROW, -(-len(chosen) // MOST_ROWS))
    pixels = np.full((-(-len(chosen) // columns), columns, 2), -1.0, np.float32)
    # A float holds no number of a frame of more than 16 million pixels, but these two.
    pixels.reshape(-1, 2)[: len(chosen)] = np.stack([chosen % size[0], chosen // size[0]], axis=-1)
    return places, pixels


class EdgeRaysPass(RenderPass):
    """Writes `edge_places`, `edge_far` and `edge_near`: all that arrives at some pixels.

    These are the pixels that a neighbour within R shades whose side towards them is hidden:
    8 % of courtyard's (320x180), in which half of its squared error was. All frames of a
    steady view share their rays; a live one has none until its probes have theirs.
    """

    name = "edge_rays"
    writes: Mapping[str, TextureSpec] = {
        name: TextureSpec(channels, "f4", own=True)
        for name, channels in zip(EDGE_RAYS, (1, 4, 4), strict=True)
    }
    is_gradual = True
    lags = False
    steady_reads = ("z_vs", "normals_vs")
    depends_on = ("steady_view", "steady_seed", "geometry", "environment")

    def __init__(
        self, settings: FarFieldSettings, features: RayFeatures, environment: EnvironmentKind
    ) -> None:
        self.settings = settings
        self.features = features
        self.environment = environment
        self.reads = (
            *self.steady_reads,
            FAR_RADIANCE,
            *ray_reads(features, shades=True),
            *CACHE_TABLES,
            *((MAP_RADIANCE,) if environment == "map" else ()),
        )

    def settings_key(self) -> Hashable:
        return self.settings, self.features, self.environment

    def execute(self, context: PassContext) -> Produced:
        """Trace the rays of some of the pixels, once the probes have all of theirs."""
        frame, probes = context.frame, context.facts[FAR_RADIANCE]
        assert isinstance(probes, ProbeRays)
        parts = refining_parts(frame.count)
        self.is_settled = True
        if not all(probes.fresh) or probes.parts < parts:
            return self._produced(context, EdgeRays(probes))
        known = facts_of(context, EDGE_RAYS[0], EdgeRays)
        rays = known if known is not None and known.source is probes else None
        rays = rays or self._begun(context, probes)
        if rays.textures:
            done = rays.parts + 1 if frame.is_live else parts
            height = rays.textures[1].height
            low, high = (height * n // parts for n in (rays.parts, done))
            self._trace(context, rays, (low, high))
            rays = replace(rays, parts=done, is_known=done == parts)
        self.is_settled = rays.is_known or not rays.textures
        return self._produced(context, rays)

    def _begun(self, context: PassContext, probes: ProbeRays) -> EdgeRays:
        """Find the pixels, and return room for what their rays will find."""
        gl, frame = context.gl, context.frame
        flags = make_texture(gl, frame.view.size, 1, "nu1")
        target = make_framebuffer(gl, [flags])
        program = context.shaders.fullscreen("effects/edge_pixels.frag", {})
        uniforms = {**frame.view.uniforms(), "u_radius": self.settings.radius}
        draw_fullscreen(gl, program, target, uniforms, textures_of(context, self.steady_reads))
        target.release()
        chosen = np.flatnonzero(np.frombuffer(flags.read(alignment=1), np.uint8))
        flags.release()
        if not len(chosen):
            return EdgeRays(probes)
        places, pixels = places_of(chosen, frame.view.size)
        size = pixels.shape[1], pixels.shape[0]
        textures = (
            make_texture(gl, frame.view.size, 1, "f4", places),
            make_texture(gl, size, 4, "f4"),
            make_texture(gl, size, 4, "f4"),
            make_texture(gl, size, 2, "f4", pixels),
        )
        return EdgeRays(probes, textures)

    def _trace(self, context: PassContext, rays: EdgeRays, rows: tuple[int, int]) -> None:
        """Trace the rays of the pixels in `rows`."""
        frame = context.frame
        defines = {
            **ray_defines(context, self.features),
            "ENVIRONMENT_KIND": ENVIRONMENT_KINDS.index(self.environment),
        }
        uniforms = {
            **ray_uniforms(context),
            **environment_uniforms(frame),
            "u_radius_ns": radius_ns(self.settings.radius, context),
            "u_stream": stream_of(frame.first_seed + (frame.moves << 32), 0),
            "u_ray_count": self.settings.edge_rays,
        }
        _, far, near, pixels = rays.textures
        reads = [name for name in self.reads if name != FAR_RADIANCE]
        textures = {**textures_of(context, reads), "t_edge_pixels": pixels}
        program = context.shaders.fullscreen("effects/edge_rays.frag", defines)
        target = make_framebuffer(context.gl, [far, near])
        region = (0, rows[0], far.width, rows[1] - rows[0])
        draw_fullscreen(context.gl, program, target, uniforms, textures, region=region)
        target.release()

    def _produced(self, context: PassContext, rays: EdgeRays) -> Produced:
        """Return the textures of `rays`, or stand-ins for those that are not known."""
        shown = rays.textures[:3] if rays.is_known else None
        if shown is None:
            shown = tuple(make_texture(context.gl, (1, 1), n, "f4", n * [0.0]) for n in (1, 4, 4))
        first, *others = shown
        named = zip(EDGE_RAYS[1:], others, strict=True)
        return {EDGE_RAYS[0]: TextureWithFacts(first, rays), **dict(named)}
