"""The screen probes of the far field: their settings, and what is known of them."""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from ssdo_gl.scene.environment import Environment, MapEnvironment
from ssdo_gl.settings.fields import setting
from ssdo_gl.settings.settings import MAX_SIZE_PX, same_as

# Where probes stand and which way they look.
FAR_POINTS = "far_probe_points"
FAR_RADIANCE = "far_radiance"
# Eight directions, which tell how bright the sky is.
SKY_DIRECTIONS = np.array(list(product((-1.0, 1.0), repeat=3))) / math.sqrt(3.0)


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
        "per-pixel rays at rest",
        unit="rays",
        low=1,
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
        "per-pixel rays while nothing but the camera, or light, moves",
        unit="rays",
        low=1,
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
        """Return the size of `FAR_RADIANCE`: two maps of every tile."""
        return tiles[0] * self.directions, 2 * tiles[1] * self.directions


def tile_count(frame_size: tuple[int, int], tile: int) -> tuple[int, int]:
    """Return columns and rows of tiles."""
    columns, rows = (-(-n // tile) for n in frame_size)
    return columns, rows


@dataclass(frozen=True, eq=False)
class ProbeRays:
    """What `far_radiance` holds.

    Attributes
    ----------
    source : hashable
        Equal for the same probes, settings and seed.
    light : hashable
        Equal for the same geometry and light.
    gives_way : bool
        There are no probes, since pixels of a frame that changes trace rays of their own.
    is_brief : bool
        More than the camera moves, so that few frames are averaged.
    """

    source: Hashable
    light: Hashable
    gives_way: bool = False
    is_brief: bool = False


def mean_radiance(environment: Environment | None) -> float:
    """Return about how bright the sky is."""
    if environment is None:
        return 0.0
    if isinstance(environment, MapEnvironment):
        rows, columns = (-(-n // 32) for n in environment.image.shape[:2])
        return float(environment.image[::rows, ::columns].mean())
    return float(environment.sample(SKY_DIRECTIONS).mean())
