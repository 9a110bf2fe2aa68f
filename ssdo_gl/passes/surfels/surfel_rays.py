"""Surfels, and what their gathering rays hit: traced once for each state of the geometry."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.graph.render_pass import PassContext, Produced, RenderPass, TextureWithFacts
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.math3d import FloatArray, IntArray
from ssdo_gl.passes.own_textures import drawing_into, facts_of, fill, textures_of
from ssdo_gl.passes.rays import bvh_of, radius_ns, ray_defines, ray_reads, ray_uniforms
from ssdo_gl.passes.surfels.bounces import Bounces
from ssdo_gl.passes.surfels.surfel_textures import (
    MOST_SURFELS,
    SLOTS_PER_ROW,
    SURFELS_PER_ROW,
    SurfaceCacheSettings,
    SurfelProgram,
    SurfelSet,
    surfel_rows,
    upload,
)
from ssdo_gl.raytracing.blind_sides import blind_sides
from ssdo_gl.raytracing.covered_points import covered, enclosed, outward, uncovered
from ssdo_gl.raytracing.graded_surfels import graded
from ssdo_gl.raytracing.openings import Openings, is_indoors, openings_of
from ssdo_gl.raytracing.slats import slat_faces
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.raytracing.surfel_patches import patches_of
from ssdo_gl.raytracing.surfel_points import NOTHING_MET, cosine_ways
from ssdo_gl.raytracing.surfels import Surfels, build_surfels
from ssdo_gl.raytracing.torn_surfels import TornSurfels, torn

# Of the number of pieces: by so many more strips are cut finer.
STRIP_SHARE = 0.5
# Scenes that are mostly empty are cut more than four times as finely, as long as no more pieces
# come of it.
SPARSE_SURFELS = 16384
# Of rays that leave rooms: fewer show no opening, so many show it well, and until there are as many
# surfels trace theirs so many times.
LEAST_LEAVING, ENOUGH_LEAVING, MOST_TURNS = 16, 512, 12
# There may be so many more at the edges of lamps.
LAMP_SURFELS = 8192
# As many are kept for those that walls part, without which light leaks and walls are too dark.
PARTED_SURFELS = 16384


class SurfelsPass(RenderPass):
    """Uploads `surfel_points`, `surfel_places` and `surfel_splits`.

    The `SurfelSet` comes with `surfel_points`, its depth with `surfel_splits`. In a live frame it
    stays what it was while objects only move.
    """

    name = "surfels"
    writes: Mapping[str, TextureSpec] = {
        "surfel_points": TextureSpec(4, "u4", own=True),
        "surfel_places": TextureSpec(2, "u4", own=True),
        "surfel_splits": TextureSpec(4, "f4", own=True),
    }
    depends_on = ("geometry",)
    is_gradual = True

    def __init__(self, settings: SurfaceCacheSettings, features: RayFeatures) -> None:
        self.settings = settings
        self.features = features
        self.reads = ray_reads(features)

    def execute(self, context: PassContext) -> Produced:
        """Cut the surfaces up and return the tables as new textures."""
        gl, bvh, scene = context.gl, bvh_of(context), context.frame.scene
        bearers = tuple(
            (o.mesh, o.material, len(o.world_from_object), o.light is None) for o in scene.objects
        )
        sides = tuple(material.single_sided for material in scene.materials)
        has_sky = scene.environment is not None
        topology = (self.settings, scene.meshes, sides, bearers, bvh.triangles.count, has_sky)
        known = facts_of(context, "surfel_points", SurfelSet)
        if known is not None and known.topology == topology:
            made, surfels = known, known.surfels.moved(bvh.triangles)
        else:
            most = self.settings.surfels
            spare = min(int(STRIP_SHARE * most), MOST_SURFELS - most)
            cut = partial(build_surfels, bvh, most, self.settings.texel, spare, SPARSE_SURFELS)
            whole = cut()
            patches = patches_of(bvh)
            ways = cosine_ways(whole.normals)
            seen = self._met(
                context,
                whole.positions,
                ways,
                np.full(ways.shape[:2], radius_ns(math.inf, context)),
            )
            openings = self._openings(context, whole, ways, *seen)
            blind = blind_sides(whole, bvh, patches, *seen)
            slats = slat_faces(whole, patches, *seen)
            if blind.any() or slats.any():
                whole = cut(blind, slats)
            # Bodies of lights, whatever they emit now: that may change, and surfels stay.
            lamps = {o.material for o in scene.objects if o.light is not None}
            glowing = [
                (i in lamps) * (1 + m.two_sided_emission) for i, m in enumerate(scene.materials)
            ] or [0]
            left = max(MOST_SURFELS - PARTED_SURFELS - whole.count, 0)
            further = min(max(most - whole.count, LAMP_SURFELS), left)
            whole = graded(whole, bvh, further, np.array(glowing)[bvh.triangles.material])
            starts, along, length = whole.lines(np.arange(whole.count))
            reach = np.where(length > 0.0, length, -1.0)
            lines = self._met(context, starts, along, reach)
            surfels = torn(whole, bvh, *lines, MOST_SURFELS)
            ways, reach = outward(surfels)
            above = self._met(context, surfels.positions, ways, reach)
            surfels = uncovered(surfels, covered(bvh, above[0], ways))
            surfels = uncovered(surfels, enclosed(surfels, partial(self._met, context)))
            made = SurfelSet(surfels, topology, whole.depth, openings)
        splits = np.zeros((made.count, 2, 4), dtype=np.float32)
        splits[:, 0], splits[:, 1, 0] = surfels.planes, surfels.others
        named = made.surfels.places.of(bvh)
        rows = -(-len(named) // SLOTS_PER_ROW)
        places = np.zeros((rows * SLOTS_PER_ROW, 2), dtype=np.uint32)
        places[: len(named)] = named
        return {
            "surfel_points": TextureWithFacts(upload(gl, _words(surfels)), made),
            "surfel_places": TextureWithFacts(
                make_texture(gl, (SLOTS_PER_ROW, rows), 2, "u4", places.tobytes()), made.openings
            ),
            "surfel_splits": TextureWithFacts(upload(gl, splits), made.depth),
        }

    def _openings(
        self,
        context: PassContext,
        whole: Surfels,
        ways: FloatArray,
        met: IntArray,
        away: FloatArray,
    ) -> Openings:
        """Return the openings through which the sky is seen, by what rays `ways` of surfels meet.

        Through a small window few of them leave: then more are traced.
        """
        if context.frame.scene.environment is None:
            return Openings(np.zeros((0, 3, 3)))
        is_open = met == NOTHING_MET
        indoors = is_indoors(is_open)
        # The insides of walls see nothing.
        looks = indoors & (is_open | (away > 0.0)).any(axis=1)
        starts, normals = whole.positions[looks], whole.normals[looks]
        rays = [(ways[looks], is_open[looks])]
        leaving = rays[0][1].sum()
        while LEAST_LEAVING <= leaving < ENOUGH_LEAVING and len(rays) < MOST_TURNS:
            more = cosine_ways(normals, len(rays))
            reach = np.full(more.shape[:2], radius_ns(math.inf, context))
            rays.append((more, self._met(context, starts, more, reach)[0] == NOTHING_MET))
            leaving += rays[-1][1].sum()
        starts, normals = (np.tile(a, (1, len(rays), 1)[: a.ndim]) for a in (starts, normals))
        ways, is_open = (np.concatenate(part, axis=1) for part in zip(*rays, strict=True))
        return Openings(openings_of(starts, ways, normals, is_open))

    def _met(
        self, context: PassContext, starts: NDArray[Any], ways: FloatArray, reach: FloatArray
    ) -> tuple[IntArray, FloatArray]:
        """Return what rays meet, 2 p + s or `NOTHING_MET`, and how far, negative from behind.

        Parameters
        ----------
        starts, ways : ndarray, shape (S, N, 3)
            Of N rays of each surfel; ways are of length 1.
        reach : ndarray, shape (S, N)
            How far they go; negative: there is none.
        """
        count, number = reach.shape
        rays = np.zeros((2, count, number, 4), dtype=np.float32)
        rays[0, ..., :3], rays[1, ..., :3], rays[1, ..., 3] = starts, ways, reach
        met = make_texture(context.gl, (SURFELS_PER_ROW, number * surfel_rows(count)), 2, "u4")
        textures = textures_of(context, self.reads)
        textures |= {"t_starts": upload(context.gl, rays[0]), "t_ways": upload(context.gl, rays[1])}
        defines, uniforms = ray_defines(context, self.features), ray_uniforms(context)
        fill(context, [met], "passes/surfel_surroundings.frag", defines, uniforms, textures)
        words = np.frombuffer(met.read(), dtype=np.uint32).reshape(number, -1, 2)
        words = words[:, :count].swapaxes(0, 1)
        return words[..., 0].astype(np.int64), words[..., 1].copy().view(np.float32)


def _words(surfels: Surfels | TornSurfels) -> NDArray[np.uint32]:
    """Return points and normals, (S, 16, 4), as `surfel_points` holds them."""
    words = np.empty((*surfels.positions.shape[:2], 4), dtype=np.uint32)
    words[..., :3], words[..., 3] = surfels.positions.view(np.uint32), surfels.normals
    return words


@dataclass(frozen=True, eq=False)
class Hits:
    """What `surfel_hits` holds.

    Attributes
    ----------
    geometry : hashable
        Equal for the same state of the geometry.
    glossy : bool
        Whether surfaces may be, and the layout has room for it.
    kept : float
        A bound on the share of light that a bounce keeps.
    traced : tuple of int
        The rows of rays that were traced last.
    missing : int
        How many rows are of an earlier state.
    number : int
        Counts up.
    """

    surfels: SurfelSet
    geometry: Hashable
    glossy: bool
    kept: float
    traced: tuple[int, ...]
    missing: int = 0
    number: int = 0


class SurfelRaysPass(RenderPass):
    """Writes `surfel_hits`: what the rays of all surfels meet, layout in its shader.

    The `Hits` come with it. While objects move, a live frame traces one row of rays after
    the other: an eighth of all.
    """

    name = "surfel_rays"
    writes: Mapping[str, TextureSpec] = {"surfel_hits": TextureSpec(2, "u4", own=True)}
    depends_on = ("geometry", "materials")
    is_gradual = True

    def __init__(self, settings: SurfaceCacheSettings, features: RayFeatures) -> None:
        self.shared = SurfelProgram(settings, features)
        self.reads = (
            "surfel_points",
            "surfel_places",
            "surfel_splits",
            *ray_reads(features, shades=True),
        )

    def execute(self, context: PassContext) -> Produced:
        """Trace, one row of rays after the other."""
        side, glossy = self.shared.settings.rays_per_side, self.shared.features.glossy
        surfels: SurfelSet = context.facts["surfel_points"]
        geometry = tuple(context.frame.versions.get(domain) for domain in self.depends_on)
        known = facts_of(context, "surfel_hits", Hits)
        words = 4 if self.shared.features.lobes else 2
        same_words = known is not None and context.last["surfel_hits"].texture.components == words
        if known is not None and known.surfels is surfels and same_words:
            texture = context.last["surfel_hits"].texture
            if known.missing == 0 and known.geometry == geometry:
                # Lights have changed, and with them the table of materials.
                self.is_settled = True
                return {"surfel_hits": TextureWithFacts(texture, known)}
            missing = (known.missing if known.geometry == geometry else side) - 1
            turn = ((known.traced[-1] + 1) % side,)
            number = known.number + 1
            made = Hits(surfels, geometry, glossy, known.kept, turn, max(missing, 0), number)
        else:
            rows = side * surfel_rows(surfels.count)
            texture = make_texture(context.gl, (side * SURFELS_PER_ROW, rows), words, "u4")
            made = Hits(surfels, geometry, glossy, 0.0, tuple(range(side)))
        self.is_settled = made.missing == 0
        rows = texture.height // side
        program = self.shared.ready(context, self.name, "SURFEL_RAYS_PER_SIDE")
        textures = textures_of(context, self.reads)
        with drawing_into(context.gl, texture) as target:
            for row in made.traced:
                region = (0, row * rows, texture.width, rows)
                draw_fullscreen(context.gl, program, target, {}, textures, region=region)
                if context.progress is not None:
                    context.gl.finish()
                    context.progress("surface cache", row + 1, side)
        if made.missing == 0:
            made = replace(made, kept=Bounces(context, texture, side, glossy).share_kept())
        return {"surfel_hits": TextureWithFacts(texture, made)}
