"""Per-pixel rays at rest: guided by the probes, more of them at contacts."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ssdo_gl.effects.moving_rays import FORMATS, moving_rays, ray_counts
from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.graph.render_pass import PassContext, Produced, RenderPass, TextureWithFacts
from ssdo_gl.graph.resource import Dtype, TextureSpec
from ssdo_gl.passes.environment_uniforms import (
    MAP_IRRADIANCE,
    MAP_RADIANCE,
    environment_defines,
    environment_uniforms,
)
from ssdo_gl.passes.far_probes import (
    FAR_POINTS,
    FAR_RADIANCE,
    FarFieldSettings,
    ProbeRays,
    mean_radiance,
)
from ssdo_gl.passes.own_lookup import OWN_RAYS, OwnRays
from ssdo_gl.passes.own_textures import facts_of, fill, textures_of
from ssdo_gl.passes.rays import radius_ns, ray_defines, ray_reads, ray_uniforms, stream_of
from ssdo_gl.passes.surfels import (
    BRIGHT_TABLES,
    bright_reads,
    cache_tables,
    opening_uniforms,
    pieces_of,
)
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.scene.environment import EnvironmentKind

SURFACES = ("z_vs", "normals_vs")
# Of a view of many frames, which share them: so many times as many, at most.
MOST_TIMES = 3
# In how many live frames they are traced, at most.
MOST_PARTS = 16
# Of textures with a texel for each such pixel: so many to a row, more where rows would be more
# than any device has.
PIXELS_PER_ROW, MOST_ROWS = 256, 8192
# Channels of the pixel's place and its normal's code.
PLACES_FORMAT: tuple[int, Dtype] = (2, "i4")
# As effects/own_pixels.frag writes it, in eight bits.
EDGE = 255


def places_of(
    chosen: NDArray[np.integer[Any]], many: int, size: tuple[int, int]
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Return where pixels have a texel of their own, and which pixel each texel stands for.

    Parameters
    ----------
    chosen : (n,) integers
        Of the frame's pixels, row by row.
    many : int
        How many of them have many rays: the first ones.
    size : (int, int)
        Width and height of the frame, pixels.

    Returns
    -------
    (height, width, 1) int32
        One more than the texel's number, negative for `many`; 0: the pixel has none.
    (rows, columns, 2) float32
        Column and row of the pixel; -1: none.
    """
    places = np.zeros((size[1], size[0], 1), np.int32)
    places.flat[chosen] = np.arange(1, len(chosen) + 1)
    places.flat[chosen[:many]] *= -1
    columns = max(PIXELS_PER_ROW, -(-len(chosen) // MOST_ROWS))
    rows = max(-(-len(chosen) // columns), 1)
    pixels = np.full((rows, columns, 2), -1.0, np.float32)
    # Floats, which hold no number of a frame of more than 16 million pixels, hold these two.
    pixels.reshape(-1, 2)[: len(chosen)] = np.stack([chosen % size[0], chosen // size[0]], axis=-1)
    return places, pixels


class OwnRaysPass(RenderPass):
    """Writes `own_places`, `own_far` and `own_near`: light gathered by per-pixel rays.

    Pixels at contacts trace more: a neighbour within R may shade them whose side towards them
    is hidden. They are 8 % of courtyard's (320x180), in which half of its squared error was.
    All frames of a steady view share their rays; where something is translucent, each has its
    part of them, for what it shows. A live frame traces some of them, or a few for each pixel where
    probes give way to them.
    """

    name = "own_rays"
    writes: Mapping[str, TextureSpec] = {
        name: TextureSpec(*form, own=True)
        for name, form in zip(OWN_RAYS, (PLACES_FORMAT, *FORMATS[:2]), strict=True)
    }
    is_gradual = True
    lags = False

    def __init__(
        self,
        settings: FarFieldSettings,
        features: RayFeatures,
        environment: EnvironmentKind,
        stride: int,
        *,
        is_steady: bool,
    ) -> None:
        self.is_steady = is_steady
        self.steady_reads = SURFACES if is_steady else ()
        domains = ("steady_view", "steady_seed") if is_steady else ("view", "seed")
        self.depends_on = (*domains, "geometry", "environment")
        self.settings = settings
        self.stride = stride
        self.many_rays = max(settings.edge_rays, settings.pixel_rays)
        self.features = features
        self.environment = environment
        self.reads = (
            *SURFACES,
            FAR_POINTS,
            FAR_RADIANCE,
            *ray_reads(features, shades=True),
            *cache_tables(features),
            *(BRIGHT_TABLES if settings.aimed_rays else ()),
            *((MAP_RADIANCE, MAP_IRRADIANCE, "ray_map_cells") if environment == "map" else ()),
        )

    def execute(self, context: PassContext) -> Produced:
        """Trace the rays of some of the pixels, or a few for each."""
        frame, probes = context.frame, context.facts[FAR_RADIANCE]
        assert isinstance(probes, ProbeRays)
        known = facts_of(context, OWN_RAYS[0], OwnRays)
        self.is_settled = True
        if probes.gives_way:
            return self._produced(self._moving(context, probes, known))
        if known is not None and (known.source, known.stride) == (probes, self.stride):
            rays = known
        else:
            rays = self._begun(context, probes)
        if not rays.is_known:
            parts = min(frame.count**2, MOST_PARTS) if self.is_steady else 1
            done = rays.parts + 1 if frame.is_live else parts
            height = rays.traced[0].height
            low, high = (height * n // parts for n in (rays.parts, done))
            self._trace(context, rays, (low, high))
            rays = replace(rays, parts=done, is_known=done == parts)
            if rays.is_known:
                # Where they start and what they follow is asked no more.
                shown = self._averaged(context, rays)
                rays = replace(rays, shown=shown, shown_view=rays.view, traced=(), seen=None)
            else:
                now = known
                if now is None or not self._is_shown(now, probes, context):
                    now = self._moving(context, probes, known)
                rays = replace(rays, shown=now.shown, shown_view=now.shown_view, seen=now.seen)
        self.is_settled = rays.is_known
        return self._produced(rays)

    def _is_shown(self, known: OwnRays, probes: ProbeRays, context: PassContext) -> bool:
        """Return whether the light that a live frame has shown is that of this one, too."""
        is_lit_so = known.source.light == probes.light and known.stride == self.stride
        return is_lit_so and known.shown_view == context.frame.view.key()

    def _moving(self, context: PassContext, probes: ProbeRays, last: OwnRays | None) -> OwnRays:
        """Return rays of every pixel of a live frame that has moved, or has none yet."""
        frame = context.frame
        counts = ray_counts(self.settings, is_brief=probes.is_brief and frame.moves > 0)
        if frame.moves == 0 and probes.gives_way:
            # Light alone changes: noise stands still, and more rays take 1.2 of the time.
            few = counts.few
            counts = counts._replace(at_contacts=few, at_outlines=few, is_brief=True)
        reads = tuple(name for name in self._read() if name not in (FAR_POINTS, *OWN_RAYS))
        # A view that begins at rest depends on none before.
        past = last.seen if last is not None and probes.gives_way else None
        made, seen = moving_rays(
            *(context, self.settings.radius, counts, self.features, self.environment),
            *(self.stride, reads, past),
        )
        nowhere = make_texture(context.gl, (1, 1), *PLACES_FORMAT, 2 * [0])
        view, shown = frame.view.key(), (nowhere, *made)
        return OwnRays(probes, view, shown, view, stride=self.stride, is_known=True, seen=seen)

    def _begun(self, context: PassContext, probes: ProbeRays) -> OwnRays:
        """Find the pixels, and return room for what their rays will find."""
        gl, frame = context.gl, context.frame
        flags = make_texture(gl, frame.view.size, 4, "nu1")
        uniforms = {
            **frame.view.uniforms(),
            "u_radius": self.settings.radius,
            "u_receiver_stride": self.stride,
        }
        surfaces = textures_of(context, SURFACES)
        fill(context, [flags], "effects/own_pixels.frag", {}, uniforms, surfaces)
        classes, code_x, code_y, _ = np.frombuffer(flags.read(), np.uint8).reshape(-1, 4).T
        flags.release()
        chosen, many = self._chosen(classes)
        places, pixels = places_of(chosen, many, frame.view.size)
        codes = (code_x + (code_y.astype(np.int32) << 8)).reshape(places.shape)
        places = np.concatenate([places, codes], axis=-1)
        size = pixels.shape[1], pixels.shape[0]
        traced = (
            make_texture(gl, size, 4, "f4"),
            make_texture(gl, size, 4, "f4"),
            make_texture(gl, frame.view.size, *PLACES_FORMAT, places),
            make_texture(gl, size, 2, "f4", pixels),
            self._guide(context),
            make_texture(gl, size, 4 if self._openings(context)[0] else 2, "f4"),
            make_texture(gl, size, 4, "f4"),
            *((make_texture(gl, size, 4, "f4"),) if pieces_of(context) is not None else ()),
        )
        return OwnRays(probes, frame.view.key(), traced=traced, stride=self.stride, many=many)

    def _guide(self, context: PassContext) -> moderngl.Texture:
        """Return how often rays are to follow each direction of the probes."""
        radiance = context.inputs[FAR_RADIANCE]
        guide = make_texture(context.gl, radiance.size, 4, "f4")
        side = {"PROBE_SIDE": self.settings.directions}
        uniforms = {"u_sky": mean_radiance(context.frame.scene.environment)}
        reads = textures_of(context, (FAR_POINTS, FAR_RADIANCE))
        fill(context, [guide], "effects/own_guide.frag", side, uniforms, reads)
        return guide

    def _chosen(self, classes: NDArray[np.uint8]) -> tuple[NDArray[np.integer[Any]], int]:
        """Return the pixels that have rays, and how many of them, the first ones, have many."""
        if self.settings.pixel_rays == self.many_rays:
            return np.flatnonzero(classes), 0
        edges = np.flatnonzero(classes == EDGE)
        others = np.flatnonzero((classes != EDGE) & (classes > 0))
        return np.concatenate([edges, others]), len(edges)

    def _trace(self, context: PassContext, rays: OwnRays, rows: tuple[int, int]) -> None:
        """Trace the rays of the pixels in `rows`."""
        frame = context.frame
        defines = {
            **ray_defines(context, self.features),
            "PROBE_TILE": self.settings.tile,
            "PROBE_SIDE": self.settings.directions,
            **environment_defines(self.environment),
        }
        seed = frame.first_seed if self.is_steady else frame.seed
        uniforms = {
            **ray_uniforms(context),
            **environment_uniforms(frame),
            "u_radius_ns": radius_ns(self.settings.radius, context),
            "u_stream": stream_of(seed, 0),
            **self._counts(context, rays),
            "u_sky": mean_radiance(frame.scene.environment),
        }
        aimed_rays = self._aimed_rays(context)
        defines["OPENINGS"], aims = self._openings(context)
        uniforms |= aims
        if self.environment == "map" or aims:
            uniforms["u_sky_rays"] = aimed_rays
        if pieces := pieces_of(context):
            uniforms |= {"u_tree_levels": pieces.tree.levels, "u_aimed_rays": aimed_rays}
        far, near, _, pixels, guide, light, rare, *aimed = rays.traced
        defines["BRIGHT_PIECES"] = len(aimed)
        textures = textures_of(context, self._read()) | bright_reads(context)
        textures |= {"t_own_pixels": pixels, "t_own_guide": guide}
        made, region = (far, near, rare, light, *aimed), (0, rows[0], far.width, rows[1] - rows[0])
        fill(context, made, "effects/own_rays.frag", defines, uniforms, textures, region)

    def _read(self) -> list[str]:
        """Return of what it reads all that goes by its own name to its shaders."""
        return [name for name in self.reads if name not in (FAR_RADIANCE, *BRIGHT_TABLES)]

    def _times(self, context: PassContext) -> float:
        """Return by how much more rays are traced, as frames share them."""
        count = context.frame.count
        return min(count, MOST_TIMES) / (1 if self.is_steady else count)

    def _aimed_rays(self, context: PassContext) -> int:
        return math.ceil(self._times(context) * self.settings.aimed_rays)

    def _openings(self, context: PassContext) -> tuple[int, dict[str, object]]:
        """Return how many openings rays are aimed at, and the uniforms for them."""
        return opening_uniforms(context) if self.settings.aimed_rays else (0, {})

    def _counts(self, context: PassContext, rays: OwnRays) -> dict[str, int]:
        """Return how many rays pixels have."""
        times = self._times(context)
        return {
            "u_many_rays": math.ceil(times * self.many_rays),
            "u_few_rays": math.ceil(times * self.settings.pixel_rays),
            "u_many_count": rays.many,
        }

    def _averaged(self, context: PassContext, rays: OwnRays) -> tuple[moderngl.Texture, ...]:
        """Return what `rays` have gathered for each pixel, averaged over pixels about."""
        far, near, places, pixels, _, light, rare, *aimed = rays.traced
        gl, size = context.gl, context.inputs[FAR_POINTS].size
        found = [make_texture(gl, size, 4, "f4"), make_texture(gl, size, 2, "f4")]
        spread = make_texture(gl, size, 4, "f4")
        once = make_texture(gl, far.size, 4, "f4")
        shown = [make_texture(gl, places.size, 4, "f4") for _ in OWN_RAYS[1:]]
        tile = {"PROBE_TILE": self.settings.tile}
        by_tile = {"t_own_places": places, "t_own_rare": rare, "t_own_light": light}
        fill(context, found, "effects/own_rare.frag", tile, {"u_tile_rows": size[1] // 2}, by_tile)
        guided = {**tile, "PROBE_SIDE": self.settings.directions}
        uniforms = {
            **context.frame.view.uniforms(),
            "u_sky": mean_radiance(context.frame.scene.environment),
        }
        reads = textures_of(context, (*SURFACES, FAR_POINTS))
        by_probe = {"t_rare": found[0], "t_light": found[1]} | reads
        fill(context, [spread], "effects/own_spread.frag", guided, uniforms, by_probe)
        by_pixel = {
            "t_own_places": places,
            "t_own_far": far,
            "t_own_rare": rare,
            "t_spread": spread,
        }
        by_pixel |= reads
        uniforms |= {"u_stride": self.stride, **self._counts(context, rays)}
        guided["BRIGHT_PIECES"] = len(aimed)
        averaged = [make_texture(gl, far.size, 4, "f4") for _ in aimed]
        if aimed:
            by_pixel["t_own_aimed"] = aimed[0]
        guided["OPENINGS"], _ = self._openings(context)
        if guided["OPENINGS"]:
            by_pixel["t_own_light"] = light
        for made, more in (
            ([once, *averaged], {"t_own_pixels": pixels}),
            (shown, {"t_own_near": near}),
        ):
            defines = {**guided, "IS_SECOND": int(made is shown)}
            textures = by_pixel | more
            fill(context, made, "effects/own_filter.frag", defines, uniforms, textures)
            by_pixel["t_own_far"] = once
            if averaged:
                by_pixel["t_own_aimed"] = averaged[0]
        return places, *shown

    def _produced(self, rays: OwnRays) -> Produced:
        """Return what is shown of `rays`."""
        first, *others = rays.shown
        named = zip(OWN_RAYS[1:], others, strict=True)
        return {OWN_RAYS[0]: TextureWithFacts(first, rays), **dict(named)}
