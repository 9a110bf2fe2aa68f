"""Per-pixel rays: the resources that hold the light they have gathered, and what is known of it."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

import moderngl

from ssdo_gl.graph.frame import FrameView
from ssdo_gl.passes.far_probes import ProbeRays

# Which pixels trace rays of their own, and the light these found beyond R and within.
OWN_RAYS = ("own_places", "own_far", "own_near")
# The light of every pixel of a frame, whose rays may be those of another frame of the view.
GATHERED = ("gathered_far", "gathered_near")


@dataclass(frozen=True, eq=False)
class SeenSurfaces:
    """What a frame that moves has seen, for the next one to tell what is new.

    Attributes
    ----------
    texture : Texture
        z, frames averaged, and the code of the shading normal, of each pixel.
    guide : Texture
        Light that these frames have found there, and its variance.
    versions : tuple of hashable
        Of bodies, lights and environment.
    """

    texture: moderngl.Texture
    guide: moderngl.Texture
    view: FrameView
    versions: tuple[Hashable, ...]


@dataclass(frozen=True, eq=False)
class OwnRays:
    """What the resources of `OWN_RAYS` hold.

    Attributes
    ----------
    source : ProbeRays
        Those of the same view and light.
    view : hashable
        Of the very frame whose pixels trace, its offset included.
    shown : tuple of moderngl.Texture
        Those of the resources: until all rays are traced, those of a frame in motion.
    shown_view : hashable
        Of the very frame that these are of.
    traced : tuple of moderngl.Texture
        Until then, what was found so far, which pixel each texel stands for, what its rays follow.
    stride : int
        Of the pixels of which one has rays at most, along each side: 2 of estimators of half size.
    many : int
        How many pixels, the first ones, have many rays.
    parts : int
        How many parts of them are traced.
    is_known : bool
        Whether all are.
    seen : SeenSurfaces or None
        Of that frame, if it moves.
    """

    source: ProbeRays
    view: Hashable
    shown: tuple[moderngl.Texture, ...] = ()
    shown_view: Hashable = None
    traced: tuple[moderngl.Texture, ...] = ()
    stride: int = 1
    many: int = 0
    parts: int = 0
    is_known: bool = False
    seen: SeenSurfaces | None = None
