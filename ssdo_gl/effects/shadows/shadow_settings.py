"""How finely shadow maps are sampled, and which: what the maps, their readers and planner share."""

from __future__ import annotations

from dataclasses import dataclass

from ssdo_gl.effects.request import Request
from ssdo_gl.effects.scene_lights import lights_of_glow
from ssdo_gl.scene.shadow_frames import AtlasLayout
from ssdo_gl.settings.fields import setting


@dataclass(frozen=True)
class ShadowMapSettings:
    """How finely shadow maps are sampled."""

    # With half of it, boxes a twentieth of the room's size lose their contact shadows.
    resolution: int = setting(
        1024,
        "texels along each face of a rectangle light's map; twice as many for point lights, "
        "four times for lights with one face: sharper shadows",
        unit="texels",
        low=16,
        high=8192,
    )
    parts_per_side: int = setting(
        2,
        "parts of a rectangle light's edges that share its map's texels: truer penumbras",
        low=1,
        high=8,
    )
    max_atlas: int = setting(
        8192,
        "texels along the atlas: with more lights, faces are halved until all fit",
        unit="texels",
        low=256,
        high=16384,
    )


def tile_size(settings: ShadowMapSettings, layout: AtlasLayout) -> int:
    """Return texels along one face."""
    size = settings.resolution
    while size * layout.side > settings.max_atlas and size > 16:
        size //= 2
    return size


def unread_maps(request: Request) -> frozenset[int]:
    """Return the lights whose shadow maps nobody reads.

    Those that are off; sample rectangles whose bodies rays look for; and those whose penumbrae rays
    find unaided.
    """
    by_rays = request.runs("shadow_edges")
    lights = enumerate(zip(request.content.lights, request.lights, strict=True))
    unread = (i for i, (light, is_on) in lights if not is_on or (by_rays and light.is_soft))
    return lights_of_glow(request).union(unread)
