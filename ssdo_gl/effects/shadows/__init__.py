"""Shadows of the scene's lights: maps, or rays."""

from __future__ import annotations

from ssdo_gl.effects.shadows.shadow_edges import ShadowEdges
from ssdo_gl.effects.shadows.shadow_map import ShadowMaps
from ssdo_gl.effects.shadows.shadow_settings import ShadowMapSettings, unread_maps
from ssdo_gl.effects.shadows.traced_shadows import TracedShadows
