"""Which shadow maps need not be drawn: what the maps, their readers and the planner agree on."""

from __future__ import annotations

from ssdo_gl.effects.request import Request
from ssdo_gl.effects.scene_lights import lights_of_glow


def unread_maps(request: Request) -> frozenset[int]:
    """Return the lights whose shadow maps nobody reads.

    Those that are off; sample rectangles whose bodies rays look for; and those whose penumbrae rays
    find unaided, unless gloss in view asks how much of them its lobes see.
    """
    by_rays = request.runs("shadow_edges") and not request.is_glossy
    lights = enumerate(zip(request.content.lights, request.lights, strict=True))
    unread = (i for i, (light, is_on) in lights if not is_on or (by_rays and light.is_soft))
    return lights_of_glow(request).union(unread)
