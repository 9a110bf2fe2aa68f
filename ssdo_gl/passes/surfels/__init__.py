"""The surface cache: irradiance kept in surfels, small pieces of the scene's surfaces."""

from __future__ import annotations

from ssdo_gl.passes.surfels.bright_tables import (
    BRIGHT_TABLES,
    BrightTablesPass,
    bright_reads,
    pieces_of,
)
from ssdo_gl.passes.surfels.surfel_bounces import SurfaceCachePass
from ssdo_gl.passes.surfels.surfel_light import SurfelDirectPass, SurfelSkyPass
from ssdo_gl.passes.surfels.surfel_rays import SurfelRaysPass, SurfelsPass
from ssdo_gl.passes.surfels.surfel_textures import (
    SurfaceCacheSettings,
    cache_tables,
    opening_uniforms,
)
