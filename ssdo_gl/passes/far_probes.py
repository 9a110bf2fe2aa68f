"""The probes of the far field: their settings, and what passes set that look them up."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from ssdo_gl.graph.render_pass import PassContext
from ssdo_gl.settings.fields import setting
from ssdo_gl.settings.settings import same_as

# Where probes stand, and which way they look.
FAR_PROBES = ("far_probe_points", "far_probe_normals")
FAR_RADIANCE = "far_radiance"
# Rays for each direction of a probe, at most: frames of a view share them. A quarter of the
# probes is one in each 2 x 2 of them.
MOST_RAYS = 16
ALL_QUARTERS = (0, 1, 2, 3)
NOTHING = (0, 0, 0, 0)
# The choices of `near_hits`; the shader knows them by number.
NEAR_HITS = ("none", "hidden", "all")


@dataclass(frozen=True)
class FarFieldSettings:
    """Settings of the far field."""

    radius: float = same_as("radius", 0.3)
    tile: int = setting(
        8, "pixels along the side of a tile, which has a probe", unit="px", low=2, high=64
    )
    directions: int = setting(
        8, "rays of each probe, along each side of its map", unit="rays", low=2, high=64
    )
    near_hits: str = setting(
        "hidden",
        "surfaces within R that rays tell of: those that the depth buffer hides, all or none",
        choices=NEAR_HITS,
    )


def probe_defines(settings: FarFieldSettings | None) -> dict[str, int]:
    """Return the switches of ``lib/far_field.glsl``; None: there is no far field."""
    if settings is None:
        return {"HAS_FAR_FIELD": 0, "PROBE_SIDE": 1}
    return {
        "HAS_FAR_FIELD": 1,
        "PROBE_TILE": settings.tile,
        "PROBE_SIDE": settings.directions,
    }


def rays_wanted(frame_count: int) -> int:
    """Return how many rays each direction has in a view of `frame_count` frames."""
    # A single frame is the quickest picture there is; one of four may take its time.
    return int(min(frame_count**2, MOST_RAYS))


@dataclass(frozen=True, eq=False)
class ProbeRays:
    """What `far_radiance` holds.

    Attributes
    ----------
    source : hashable
        Equal for the same probes and settings.
    light : hashable
        Equal for the same geometry and light.
    counts : tuple of int
        Of each quarter, how many rays were added up for each direction.
    fresh : tuple of int
        How many of them are of that light.
    following : int
        The quarter whose turn is next where light changes.
    """

    source: Hashable
    light: Hashable
    counts: tuple[int, ...] = NOTHING
    fresh: tuple[int, ...] = NOTHING
    following: int = 0

    def of_light(self, light: Hashable) -> ProbeRays:
        """Return the same of another light, of which nothing is known yet."""
        return replace(self, light=light, fresh=NOTHING)

    def turns(self, wanted: int, *, is_live: bool) -> Iterator[tuple[int, tuple[int, ...]]]:
        """Yield number and quarters of the rays to be traced now; number 0 replaces others."""
        stale = tuple(q for q, fresh in enumerate(self.fresh) if fresh == 0)
        if not is_live:
            yield from ((number, ALL_QUARTERS) for number in range(wanted))
        elif stale == ALL_QUARTERS:
            yield 0, (self.following,)
        elif stale:
            yield 0, stale
        elif self.fresh[0] < wanted:
            yield self.fresh[0], ALL_QUARTERS

    def with_turn(self, quarters: tuple[int, ...]) -> ProbeRays:
        """Return what there is after one more ray for `quarters`."""
        fresh = tuple(n + (q in quarters) for q, n in enumerate(self.fresh))
        counts = tuple(new or old for new, old in zip(fresh, self.counts, strict=True))
        following = (quarters[-1] + 1) % len(ALL_QUARTERS)
        return replace(self, counts=counts, fresh=fresh, following=following)


def probe_uniforms(context: PassContext) -> dict[str, Any]:
    """Return the uniforms of ``lib/far_field.glsl``, none where there is no far field."""
    rays = context.facts.get(FAR_RADIANCE)
    if rays is None:
        return {}
    return {"u_inv_ray_counts": tuple(1.0 / n if n else 0.0 for n in rays.counts)}
