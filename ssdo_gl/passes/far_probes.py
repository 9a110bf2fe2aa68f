"""The screen probes of the far field: their settings, and what passes set to look them up."""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from ssdo_gl.graph.render_pass import PassContext
from ssdo_gl.scene.environment import Environment, MapEnvironment
from ssdo_gl.settings.fields import setting
from ssdo_gl.settings.settings import MAX_SIZE_PX, same_as

# Where probes stand and which way they look.
FAR_POINTS = "far_probe_points"
FAR_RADIANCE = "far_radiance"
# Eight directions, which tell how bright the sky is.
SKY_DIRECTIONS = np.array(list(product((-1.0, 1.0), repeat=3))) / math.sqrt(3.0)
# A quarter of the probes is one in each 2 x 2 of them.
ALL_QUARTERS = (0, 1, 2, 3)
NOTHING = (False,) * 4


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
    pixel_rays: int = setting(
        6,
        "per-pixel rays at rest; 0: none",
        unit="rays",
        low=0,
        high=1024,
    )
    edge_rays: int = setting(
        16,
        "the same where a neighbour in front may shade, no fewer than others have; while bodies"
        " move as many everywhere, and there four times as many",
        unit="rays",
        low=0,
        high=1024,
    )
    aimed_rays: int = setting(
        4,
        "aimed at small pieces, far brighter than the rest, and as many at windows, or at what is"
        " bright in an image of the sky; a quarter while the camera moves",
        unit="rays",
        low=0,
        high=64,
    )
    moving_rays: int = setting(
        2,
        "per-pixel rays while nothing but the camera moves; 0: none in motion",
        unit="rays",
        low=0,
        high=64,
    )
    moving_edge_rays: int = setting(
        8,
        "the same where a neighbour in front may shade, no fewer than others have",
        unit="rays",
        low=0,
        high=64,
    )
    moving_outline_rays: int = setting(
        32,
        "the same where fewer than 3 of the 8 pixels around show the same surface",
        unit="rays",
        low=0,
        high=64,
    )
    moving_lost_rays: int = setting(
        16,
        "at most, where the last frame shows little of a pixel's surface, by that little the more",
        unit="rays",
        low=0,
        high=64,
    )

    def fitting(self, frame_size: tuple[int, int]) -> FarFieldSettings:
        """Return them with tiles so large that the map of all probes of a frame is an image."""
        tile = self.tile
        while max(self.map_size(tile_count(frame_size, tile))) > MAX_SIZE_PX:
            tile *= 2
        return replace(self, tile=tile)

    def map_size(self, tiles: tuple[int, int]) -> tuple[int, int]:
        """Return the size of `FAR_RADIANCE`: two maps of every probe, whole quarters of them."""
        columns, rows = (2 * -(-n // 2) for n in tiles)
        return columns * self.directions, 2 * rows * self.directions


def tile_count(frame_size: tuple[int, int], tile: int) -> tuple[int, int]:
    """Return columns and rows of tiles."""
    columns, rows = (-(-n // tile) for n in frame_size)
    return columns, rows


def probe_defines(settings: FarFieldSettings | None) -> dict[str, int]:
    """Return the switches of ``lib/far_field.glsl``; None: there is no far field."""
    if settings is None:
        return {"HAS_FAR_FIELD": 0, "PROBE_SIDE": 1}
    return {
        "HAS_FAR_FIELD": 1,
        "PROBE_TILE": settings.tile,
        "PROBE_SIDE": settings.directions,
    }


@dataclass(frozen=True, eq=False)
class ProbeRays:
    """What `far_radiance` holds.

    Attributes
    ----------
    source : (hashable, hashable)
        Equal for the same probes and settings, and for the same seed.
    light : hashable
        Equal for the same geometry and light.
    known : tuple of bool
        Of each quarter, whether there is a ray for each direction.
    fresh : tuple of bool
        Whether it is of that light.
    following : tuple of int
        The quarters whose turn is next where none is of that light.
    gives_way : bool
        No probe is looked up, since pixels of a view that moves trace rays of their own.
    is_brief : bool
        More than the camera moves, so that few frames are averaged.
    """

    source: tuple[Hashable, Hashable]
    light: Hashable
    following: tuple[int, ...]
    known: tuple[bool, ...] = NOTHING
    fresh: tuple[bool, ...] = NOTHING
    gives_way: bool = False
    is_brief: bool = False

    def of_light(self, light: Hashable) -> ProbeRays:
        """Return the same of another light, of which nothing is known yet."""
        return replace(self, light=light, fresh=NOTHING)

    def turn(self, *, is_live: bool) -> tuple[int, ...]:
        """Return the quarters whose rays are to be traced now."""
        if self.gives_way:
            return ()
        stale = tuple(q for q, fresh in enumerate(self.fresh) if not fresh)
        return self.following if is_live and stale == ALL_QUARTERS else stale

    def with_turn(self, quarters: tuple[int, ...]) -> ProbeRays:
        """Return what there is after one more ray for `quarters`."""
        fresh = tuple(is_fresh or q in quarters for q, is_fresh in enumerate(self.fresh))
        known = tuple(new or old for new, old in zip(fresh, self.known, strict=True))
        following = ((quarters[-1] + 1) % len(ALL_QUARTERS),)
        return replace(self, known=known, fresh=fresh, following=following)

    def looked_up(self) -> tuple[bool, ...]:
        """Return which quarters are looked up: all, or that alone which was traced last.

        Probes of two or three of them would stand in no grid.
        """
        if all(self.known):
            return self.known
        last = (self.following[0] - 1) % len(ALL_QUARTERS)
        return tuple(quarter == last for quarter in ALL_QUARTERS)


def mean_radiance(environment: Environment | None) -> float:
    """Return about how bright the sky is."""
    if environment is None:
        return 0.0
    if isinstance(environment, MapEnvironment):
        rows, columns = (-(-n // 32) for n in environment.image.shape[:2])
        return float(environment.image[::rows, ::columns].mean())
    return float(environment.sample(SKY_DIRECTIONS).mean())


def probe_uniforms(context: PassContext) -> dict[str, Any]:
    """Return the uniforms of ``lib/far_field.glsl``, none where there is no far field."""
    rays = context.facts.get(FAR_RADIANCE)
    if rays is None:
        return {}
    return {"u_inv_ray_counts": tuple(map(float, rays.looked_up()))}
