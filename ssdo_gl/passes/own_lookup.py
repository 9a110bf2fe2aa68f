"""Per-pixel rays: what passes set that look up the light they have gathered."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import Any

import moderngl

from ssdo_gl.graph.frame import FrameView
from ssdo_gl.graph.render_pass import PassContext
from ssdo_gl.passes.far_probes import ProbeRays

# Which pixels trace rays of their own, and the light these found beyond R and within.
OWN_RAYS = ("own_places", "own_far", "own_near")


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
    textures : tuple of moderngl.Texture
        Those of the resources; until all rays are traced, which pixel each texel stands for and
        what its rays follow, too. None: there is no such pixel.
    stride : int
        Of the pixels of which one has rays at most, along each side: 2 of estimators of half size.
    many : int
        How many pixels, the first ones, have many rays.
    parts : int
        How many parts of them are traced.
    is_known : bool
        Whether all are.
    are_all : bool
        Every pixel that shows a surface has some, of that very frame.
    seen : SeenSurfaces or None
        Of that frame, if it moves.
    """

    source: ProbeRays
    textures: tuple[moderngl.Texture, ...] = ()
    stride: int = 1
    many: int = 0
    parts: int = 0
    is_known: bool = False
    are_all: bool = False
    seen: SeenSurfaces | None = None


def own_uniforms(context: PassContext) -> dict[str, Any]:
    """Return whether `own_places` holds anything, nothing where no pixel may have rays."""
    rays = context.facts.get(OWN_RAYS[0])
    return {} if rays is None else {"u_has_own_rays": rays.is_known}


def own_defines(context: PassContext) -> dict[str, int]:
    """Return the switch of ``lib/own_rays.glsl``."""
    has_rays = OWN_RAYS[0] in context.facts
    return {"HAS_OWN_RAYS": 2 if tell_all(context.facts) else int(has_rays)}


def tell_all(facts: Mapping[str, object]) -> bool:
    """Return whether every pixel that shows a surface has rays of that very frame."""
    rays = facts.get(OWN_RAYS[0])
    return isinstance(rays, OwnRays) and rays.is_known and rays.are_all
