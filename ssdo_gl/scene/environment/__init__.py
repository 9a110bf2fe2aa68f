"""Distant light: its kinds, daylight, and its images as surfaces see it."""

from __future__ import annotations

from ssdo_gl.scene.environment.daylight import SUN, Daylight, SkyEnvironment, sky, with_sun
from ssdo_gl.scene.environment.environment_kinds import (
    ENVIRONMENT_KINDS,
    ConstantEnvironment,
    Environment,
    EnvironmentKind,
    GradientEnvironment,
    MapEnvironment,
    kind_of,
    texels,
)
from ssdo_gl.scene.environment.environment_light import irradiance, radiance_image
from ssdo_gl.scene.environment.environment_lobes import lobe_levels
from ssdo_gl.scene.environment.sun_of_map import sun_apart, sun_note, sun_of, turned_sun
