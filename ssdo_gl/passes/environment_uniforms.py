"""What every pass that includes ``lib/environment.glsl`` needs, as plain data."""

from __future__ import annotations

from ssdo_gl.graph.frame import Frame
from ssdo_gl.scene.environment import (
    ENVIRONMENT_KINDS,
    ConstantEnvironment,
    EnvironmentKind,
    GradientEnvironment,
)

# Resources that hold a map; the other kinds need no texture.
MAP_RADIANCE = "environment"
MAP_IRRADIANCE = "environment_irradiance"


def environment_defines(environment: EnvironmentKind) -> dict[str, int]:
    """Return the define ``ENVIRONMENT_KIND``: 0 none, 1 constant, 2 gradient, 3 map."""
    return {"ENVIRONMENT_KIND": ENVIRONMENT_KINDS.index(environment)}


def environment_uniforms(frame: Frame) -> dict[str, object]:
    """Return the uniforms that ``lib/environment.glsl`` declares."""
    environment = frame.scene.environment
    values: dict[str, object] = {"u_world_from_view": frame.view.world_from_view}
    if isinstance(environment, ConstantEnvironment):
        values["u_environment_zenith"] = environment.radiance
    elif isinstance(environment, GradientEnvironment):
        values["u_environment_zenith"] = environment.zenith
        values["u_environment_horizon"] = environment.horizon
        values["u_environment_ground"] = environment.ground
    return values
