"""Irradiance of surfels by all light: bounces are added until nothing is missing."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import moderngl
import numpy as np

from ssdo_gl.gpu.texture import read_texture
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
    light, last_but_one : Texture
        The last bounce and the one before.
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
    light: moderngl.Texture
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

    def execute(self, context: PassContext) -> Produced:
        """Add bounces: until what is missing is below the tolerance, or as many as fit a frame."""
        hits = context.facts["surfel_hits"]
        side, lobes = self.shared.settings.rays_per_side, self.shared.features.lobes
        bounces = Bounces(context, context.inputs["surfel_hits"], side, hits.glossy)
        known = facts_of(context, "surface_cache", Convergence)
        budget = None
        if known is None or known.sources[0] is not hits.surfels or (known.rest is None) == lobes:
            made = self._begun(context, bounces)
        else:
            made = self._resumed(context, known)
            budget = RESTING_BOUNCES if context.is_complete else LIVE_BOUNCES
        while made.factors:
            made = self._summed(context, bounces, made, budget)
            if budget:
                break
        self.is_settled = not made.factors
        produced: Produced = {"surface_cache": TextureWithFacts(made.light, made)}
        return produced if made.rest is None else {**produced, "surfel_rest": made.rest}

    def _begun(self, context: PassContext, bounces: Bounces) -> Convergence:
        """Return that nothing is summed yet but, with lobes, the first bounce."""
        direct, black = context.inputs["surfel_direct"], bounces.texture(0.0)
        made = Convergence(_sources(context), black, black, self._factors(context), direct)
        if self.shared.features.lobes:
            light = bounces.step(direct, black, black, 1.0)
            sent = self._sent(context, light, black)
            made = replace(made, light=light, sent=sent, rest=black, turns=LOBE_TURNS)
        return made

    def _resumed(self, context: PassContext, known: Convergence) -> Convergence:
        """Return what is known, to go on with: to be summed again if it is of another light."""
        sources = _sources(context)
        if all(a is b for a, b in zip(known.sources, sources, strict=True)):
            return known
        sent, turns = context.inputs["surfel_direct"], 0
        if known.rest is not None:
            sent, turns = self._sent(context, known.light, known.rest), LOBE_TURNS
        factors = self._factors(context, is_plain=known.is_plain)
        return replace(known, sources=sources, factors=factors, sent=sent, turns=turns)

    def _summed(
        self, context: PassContext, bounces: Bounces, made: Convergence, budget: int | None
    ) -> Convergence:
        """Return the next steps of a sum, and behind its last one how to go on."""
        steps, left = made.factors[:budget], made.factors[budget:] if budget else ()
        light, last_but_one = made.light, made.last_but_one
        for over in steps:
            light, last_but_one = bounces.step(made.sent, light, last_but_one, over), light
        made = replace(made, light=light, last_but_one=last_but_one, factors=left)
        if left:
            return made
        # Whether it grows depends on what surfels see of each other, not on light.
        kept = context.facts["surfel_hits"].kept
        if not budget and not made.is_plain and bounces.grow(kept, made.sent, light):
            black, factors = bounces.texture(0.0), self._factors(context, is_plain=True)
            return replace(made, light=black, last_but_one=black, factors=factors, is_plain=True)
        if made.rest is None:
            return made
        rest = self._drawn(context, "surfel_rest", light)
        if not made.turns:
            return replace(made, rest=rest)
        sent, factors = self._sent(context, light, rest), ()
        if made.turns == LOBE_TURNS or _change(made.sent, sent) > LOBE_CHANGE:
            factors = self._factors(context, is_plain=made.is_plain)
        return replace(made, factors=factors, sent=sent, rest=rest, turns=made.turns - 1)

    def _factors(self, context: PassContext, *, is_plain: bool = False) -> tuple[float, ...]:
        tolerance = LOBE_TOLERANCE if self.shared.features.lobes else TOLERANCE
        return tuple(relaxation(context.facts["surfel_hits"].kept, tolerance, is_plain=is_plain))

    def _sent(
        self, context: PassContext, light: moderngl.Texture, rest: moderngl.Texture
    ) -> moderngl.Texture:
        """Return direct light and what lobes send on of `light`, less that as if diffuse."""
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


def _sources(context: PassContext) -> tuple[object, ...]:
    hits = context.facts["surfel_hits"]
    return hits.surfels, hits, context.inputs["surfel_direct"]


def _change(before: moderngl.Texture, after: moderngl.Texture) -> float:
    """Return the mean absolute difference of the light that surfels are sent, over its mean."""
    old, new = (read_texture(texture)[..., :3] for texture in (before, after))
    return float(np.abs(new - old).sum() / max(np.abs(new).sum(), np.finfo(np.float32).tiny))
