"""The probes of the far field: their settings, and what passes set that look them up."""

from __future__ import annotations

from dataclasses import dataclass

from ssdo_gl.settings.fields import setting
from ssdo_gl.settings.settings import same_as

# Where probes stand, and which way they look.
FAR_PROBES = ("far_probe_points", "far_probe_normals")
FAR_RADIANCE = "far_radiance"
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
        return {"HAS_FAR_FIELD": 0}
    return {
        "HAS_FAR_FIELD": 1,
        "PROBE_TILE": settings.tile,
        "PROBE_SIDE": settings.directions,
    }
