"""Rays of single pixels: what passes set that look up what these have found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import moderngl

from ssdo_gl.graph.render_pass import PassContext
from ssdo_gl.passes.far_probes import ProbeRays

# Which pixels have rays of their own, and what these found beyond R and within.
EDGE_RAYS = ("edge_places", "edge_far", "edge_near")


@dataclass(frozen=True, eq=False)
class EdgeRays:
    """What the resources of `EDGE_RAYS` hold.

    Attributes
    ----------
    source : ProbeRays
        Those of the same view and light.
    textures : tuple of moderngl.Texture
        Those of the resources, and which pixel each texel stands for; none: there is no
        such pixel.
    parts : int
        How many parts of them are traced.
    is_known : bool
        Whether all are.
    """

    source: ProbeRays
    textures: tuple[moderngl.Texture, ...] = ()
    parts: int = 0
    is_known: bool = False


def edge_uniforms(context: PassContext) -> dict[str, Any]:
    """Return the uniforms of ``lib/edge_rays.glsl``, none where no pixel may have rays."""
    rays = context.facts.get(EDGE_RAYS[0])
    return {} if rays is None else {"u_has_edge_rays": rays.is_known}
