"""What other effects look up: environment, gloss, the scene for rays, light on surfaces."""

from __future__ import annotations

from ssdo_gl.effects.tables.environment import EnvironmentImage
from ssdo_gl.effects.tables.gloss_tables import GlossTables
from ssdo_gl.effects.tables.ray_data import RayData
from ssdo_gl.effects.tables.surface_cache import SurfaceCache
