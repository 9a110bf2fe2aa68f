"""How finely shadow maps are sampled: what the maps, their readers and the planner agree on."""

from __future__ import annotations

from dataclasses import dataclass

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
