"""Irradiance of surfels by all light: bounces are added until nothing is missing."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass

import moderngl
import numpy as np

from ssdo_gl.gpu.readback import read_texture
from ssdo_gl.graph.render_pass import PassContext, Produced, RenderPass, TextureWithFacts
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.own_textures import facts_of, textures_of
from ssdo_gl.passes.surfels.bounces import TOLERANCE, Bounces, relaxation
from ssdo_gl.passes.surfels.surfel_textures import (
    SurfaceCacheSettings,
    SurfelProgram,
    drawn,
    surfel_rows,
)
from ssdo_gl.raytracing.surface_tables import RayFeatures

# Bounces of a live frame while direct light changes, and once it rests: then no shadow rays are
# traced, which took as long as two more of them.
LIVE_BOUNCES, RESTING_BOUNCES = 2, 4
# With lobes bounces are summed, and summed again with what lobes send on of the last sum, by
# directions, once at least and until that changes by less than this, of itself. Each time changes a
# tenth of what the last one did, in rooms of metal a third: then three leave .3 % (RMS).
LOBE_TURNS = 3
LOBE_CHANGE = 2e-3
# Of each sum: two, of which one goes on from the other, leave as little as one without lobes.
LOBE_TOLERANCE = math.sqrt(TOLERANCE)


@dataclass(frozen=True, eq=False)
class Convergence:
    """How far the bounces have come that `surface_cache` holds.

    Attributes
    ----------
    sources : tuple
        Stand for direct light, and for what surfels see of each other.
    last_but_one : Texture
        The bounce before.
    factors : tuple of float
        Of the steps that are left.
    sent : Texture
        What bounces start from: direct light, and what lobes do to it.
    rest : Texture or None
        With lobes, from where light arrives that is not direct, as of the last sum.
    turns : int
        How many sums are left after this one.
    is_plain : bool
        Whether Chebyshev's iteration grew, so that bounces are plain ones.
    """

    sources: tuple[object, ...]
    last_but_one: moderngl.Texture
    factors: tuple[float, ...]
    sent: moderngl.Texture
    rest: moderngl.Texture | None = None
    turns: int = 0
    is_plain: bool = False


class SurfaceCachePass(RenderPass):
    """Writes `surface_cache`: irradiance of surfels by all light, any number of bounces.

    In a live frame it goes on from what it has, a few bounces at a time. With lobes it writes
    `surfel_rest`, too: from where light arrives that is not direct.
    """

    name = "surface_cache"
    writes: Mapping[str, TextureSpec] = {"surface_cache": TextureSpec(4, "f4", own=True)}
    is_gradual = True

    def __init__(self, settings: SurfaceCacheSettings, features: RayFeatures) -> None:
        self.shared = SurfelProgram(settings, features)
        self.reads = ("surfel_points", "surfel_hits", "surfel_direct")
        if features.lobes:
            self.reads += ("surfel_quarters", "bvh")
            self.writes = {**self.writes, "surfel_rest": TextureSpec(4, "f4", own=True)}

    def settings_key(self) -> Hashable:
        return self.shared

    def execute(self, context: PassContext) -> Produced:
        """Add bounces: until what is missing is below the tolerance, or as many as fit a frame."""
        hits, direct = context.facts["surfel_hits"], context.inputs["surfel_direct"]
        side, lobes = self.shared.settings.rays_per_side, self.shared.features.lobes
        bounces = Bounces(context, context.inputs["surfel_hits"], side, hits.glossy)
        sources = (hits.surfels, hits, direct)
        known = facts_of(context, "surface_cache", Convergence)
        budget = None
        of_same = known is not None and (known.rest is not None) == lobes
        of_same = known is not None and of_same and known.sources[0] is hits.surfels
        is_plain = known is not None and of_same and known.is_plain
        tolerance, turns = LOBE_TOLERANCE if lobes else TOLERANCE, LOBE_TURNS * lobes
        factors = tuple(relaxation(hits.kept, tolerance, is_plain=is_plain))
        if known is not None and of_same:
            last, last_but_one = context.last["surface_cache"].texture, known.last_but_one
            rest, sent = known.rest, direct
            if all(a is b for a, b in zip(known.sources, sources, strict=True)):
                factors, turns, sent = known.factors, known.turns, known.sent
            elif lobes:
                sent = self._sent(context, last, rest)
            budget = RESTING_BOUNCES if context.is_complete else LIVE_BOUNCES
        else:
            last, last_but_one = bounces.texture(0.0), bounces.texture(0.0)
            rest, sent = None, direct
            if lobes:
                last, rest = bounces.step(direct, last, last, 1.0), bounces.texture(0.0)
                sent = self._sent(context, last, rest)
        while factors:
            steps, factors = factors[:budget], factors[budget:] if budget else ()
            for over in steps:
                last_but_one, last = last, bounces.step(sent, last, last_but_one, over)
            if not factors and not is_plain and bounces.grow(hits.kept, sent, last):
                is_plain, last, last_but_one = True, bounces.texture(0.0), bounces.texture(0.0)
                factors = tuple(relaxation(hits.kept, tolerance, is_plain=True))
            elif not factors and lobes:
                rest = self._drawn(context, "surfel_rest", last)
                if turns:
                    before, sent = sent, self._sent(context, last, rest)
                    if turns == LOBE_TURNS or _change(before, sent) > LOBE_CHANGE:
                        factors = tuple(relaxation(hits.kept, tolerance, is_plain=is_plain))
                    turns -= 1
            if budget:
                break
        self.is_settled = not factors
        made = Convergence(sources, last_but_one, factors, sent, rest, turns, is_plain)
        produced: Produced = {"surface_cache": TextureWithFacts(last, made)}
        return produced if rest is None else {**produced, "surfel_rest": rest}

    def _sent(
        self, context: PassContext, light: moderngl.Texture, rest: moderngl.Texture | None
    ) -> moderngl.Texture:
        """Return direct light and what lobes send on of `light`, less that as if diffuse."""
        assert rest is not None
        direct = textures_of(context, ("surfel_direct", "surfel_quarters"))
        return self._drawn(context, "surfel_mirrored", light, {**direct, "t_surfel_rest": rest})

    def _drawn(
        self,
        context: PassContext,
        name: str,
        light: moderngl.Texture,
        further: Mapping[str, moderngl.Texture] | None = None,
    ) -> moderngl.Texture:
        """Return what a program makes of the light of surfels, over their rays."""
        rows = surfel_rows(context.facts["surfel_points"].count)
        program = self.shared.ready(context, name, "SURFEL_RAYS_PER_SIDE")
        textures = textures_of(context, ("surfel_points", "surfel_hits"))
        textures |= {"t_surface_cache": light, **(further or {})}
        return drawn(context.gl, rows, program, {}, textures)


def _change(before: moderngl.Texture, after: moderngl.Texture) -> float:
    """Return the mean absolute difference of the light that surfels are sent, over its mean."""
    old, new = (read_texture(texture)[..., :3] for texture in (before, after))
    return float(np.abs(new - old).sum() / max(np.abs(new).sum(), np.finfo(np.float32).tiny))
