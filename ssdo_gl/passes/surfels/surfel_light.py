"""Irradiance of surfels: direct from sky and lights, and any number of bounces between them.

What their rays meet is known, so that light is gathered without any ray; only shadow rays
follow where lights move.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace

import moderngl
import numpy as np

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.graph.render_pass import PassContext, Produced, RenderPass, TextureWithFacts
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.environment_uniforms import MAP_RADIANCE
from ssdo_gl.passes.own_textures import drawing_into, facts_of, fill, textures_of
from ssdo_gl.passes.rays import (
    EMITTER_TABLES,
    GLOW_PLACES,
    GLOW_TREE,
    emitters_of,
    ray_reads,
    tree_of,
    tree_uniforms,
)
from ssdo_gl.passes.surfels.surfel_textures import (
    SURFELS_PER_ROW,
    SurfaceCacheSettings,
    SurfelProgram,
    surfel_rows,
)
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.scene.environment import EnvironmentKind

# More groups of lights than this are drawn from by chance instead of gone through.
MOST_GROUPS = 16


@dataclass(frozen=True, eq=False)
class SkyLight:
    """Of which state `surfel_sky` is: the number of the hits, and the sky; all that is drawn."""

    surfels: object
    number: int
    sky: Hashable
    textures: tuple[moderngl.Texture, ...] = ()


class SurfelSkyPass(RenderPass):
    """Writes `surfel_sky`: irradiance by the sky that rays met, a tile for each row of them.

    Of a map it is what shadow rays, which draw from it, leave to these.
    """

    name = "surfel_sky"
    writes: Mapping[str, TextureSpec] = {"surfel_sky": TextureSpec(4, "f4", own=True)}
    depends_on = ("geometry", "environment")
    is_gradual = True

    def __init__(
        self,
        settings: SurfaceCacheSettings,
        features: RayFeatures,
        environment: EnvironmentKind,
    ) -> None:
        self.shared = SurfelProgram(settings, features, environment)
        map_tables = ("ray_map_cells", MAP_RADIANCE) if environment == "map" else ()
        self.reads = (*ray_reads(features), "surfel_points", "surfel_hits", *map_tables)

    def execute(self, context: PassContext) -> Produced:
        """Add up the sky in all directions that are open."""
        side, hits = self.shared.settings.rays_per_side, context.facts["surfel_hits"]
        rows = surfel_rows(context.facts["surfel_points"].count)
        made = SkyLight(hits.surfels, hits.number, context.frame.versions.get("environment"))
        known = facts_of(context, "surfel_sky", SkyLight)
        same = known is not None and (known.surfels, known.sky) == (made.surfels, made.sky)
        count = self.shared.light_count
        same = same and known is not None and len(known.textures) == count
        turn: tuple[int, ...] = tuple(range(side))
        if known is not None and same and made.number - known.number in (0, 1):
            made = replace(made, textures=known.textures)
            turn = hits.traced if made.number > known.number else ()
        else:
            size = (SURFELS_PER_ROW, side * rows)
            made = replace(made, textures=self.shared.light_textures(context.gl, size))
        program = self.shared.ready(context, self.name, "SURFEL_RAYS_PER_SIDE", "OPENINGS")
        textures = textures_of(context, self.reads)
        with drawing_into(context.gl, *made.textures) as target:
            for row in turn:
                region = (0, row * rows, SURFELS_PER_ROW, rows)
                draw_fullscreen(context.gl, program, target, {}, textures, region=region)
        return {"surfel_sky": TextureWithFacts(made.textures[0], made)}


@dataclass(frozen=True, eq=False)
class DirectLight:
    """What shadow rays have found, and equal for the same surfels, light and settings.

    With lobes there are four textures more by directions.
    """

    made_from: Hashable
    textures: tuple[moderngl.Texture, ...]


class SurfelDirectPass(RenderPass):
    """Writes `surfel_direct`: irradiance by sky, lights and all that glows."""

    name = "surfel_direct"
    writes: Mapping[str, TextureSpec] = {"surfel_direct": TextureSpec(4, "f4", own=True)}
    depends_on = ("geometry", "materials", "lights", "environment")

    def __init__(
        self,
        settings: SurfaceCacheSettings,
        features: RayFeatures,
        environment: EnvironmentKind,
    ) -> None:
        self.shared = SurfelProgram(settings, features, environment)
        self.rays = (
            "surfel_points",
            *ray_reads(features, shades=True),
            *EMITTER_TABLES,
            *((MAP_RADIANCE,) if environment == "map" else ()),
            *((*GLOW_TREE, GLOW_PLACES) if features.glow_is_direct else ()),
        )
        self.reads = (*self.rays, "surfel_sky")
        if features.lobes:
            self.writes = {**self.writes, "surfel_quarters": TextureSpec(4, "f4", own=True)}

    def execute(self, context: PassContext) -> Produced:
        """Trace shadow rays, unless the sky alone has become better known."""
        known = facts_of(context, "surfel_direct", DirectLight)
        light = tuple(context.frame.versions.get(domain) for domain in self.depends_on)
        made, made_from = known, (context.facts["surfel_points"], light, self.shared)
        if made is None or made.made_from != made_from:
            made = DirectLight(made_from, self._traced(context))
        found = self._sums(context, made.textures[:1])
        produced: Produced = {"surfel_direct": TextureWithFacts(found, made)}
        if self.shared.features.lobes:
            produced = {**produced, "surfel_quarters": self._sums(context, made.textures)}
        return produced

    def _traced(self, context: PassContext) -> tuple[moderngl.Texture, ...]:
        """Return what shadow rays find, as new textures."""
        size = (SURFELS_PER_ROW, surfel_rows(context.facts["surfel_points"].count))
        found = self.shared.light_textures(context.gl, size)
        program = self.shared.ready(context, self.name)
        with drawing_into(context.gl, *found) as target:
            samples = self._samples(context)
            draw_fullscreen(context.gl, program, target, samples, textures_of(context, self.rays))
        return found

    def _sums(self, context: PassContext, found: tuple[moderngl.Texture, ...]) -> moderngl.Texture:
        """Return the sums with the sky, of all light and by directions, a tile each."""
        rows = surfel_rows(context.facts["surfel_points"].count)
        texture = make_texture(context.gl, (SURFELS_PER_ROW, len(found) * rows), 4, "f4")
        defines = {"SURFEL_RAYS_PER_SIDE": self.shared.settings.rays_per_side}
        for tile, (light, sky) in enumerate(
            zip(found, context.facts["surfel_sky"].textures, strict=False)
        ):
            fill(
                context,
                [texture],
                "passes/surfel_sum.frag",
                {**defines, "OF_QUARTER": int(tile > 0)},
                {"u_surfel_rows": rows, "u_first_row": tile * rows},
                {"t_surfel_light": light, "t_surfel_sky": sky},
                (0, tile * rows, SURFELS_PER_ROW, rows),
            )
        return texture

    def _samples(self, context: PassContext) -> dict[str, object]:
        """Return the uniforms that say how many rays go to each group of lights."""
        tables, glow = emitters_of(context), {}
        groups = tables.group_count
        samples = self.shared.settings.light_samples
        if self.shared.features.glow_is_direct:
            glow = {**tree_uniforms(context), "u_tree_samples": samples}
            in_tree = tables.groups[:, 0, 2].astype(np.int64) & tree_of(context).codes
            groups -= int((in_tree != 0).sum())
        draws = groups > MOST_GROUPS
        each = samples if draws else max(1, samples // max(groups, 1))
        return {"u_samples": each, "u_draws_groups": draws, **glow}
