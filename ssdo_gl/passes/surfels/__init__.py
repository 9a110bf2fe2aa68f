"""The surface cache: irradiance kept in surfels, small pieces of the scene's surfaces."""

from __future__ import annotations

from ssdo_gl.passes.surfels.surfel_light import SurfaceCachePass, SurfelDirectPass, SurfelSkyPass
from ssdo_gl.passes.surfels.surfel_rays import SurfelRaysPass, SurfelsPass
from ssdo_gl.passes.surfels.surfel_textures import (
    CACHE_TABLES,
    SurfaceCacheSettings,
)

__all__ = [
    "CACHE_TABLES",
    "SurfaceCachePass",
    "SurfaceCacheSettings",
    "SurfelDirectPass",
    "SurfelRaysPass",
    "SurfelSkyPass",
    "SurfelsPass",
]
