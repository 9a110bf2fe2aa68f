"""The lights of a scene. Plain data in world space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ssdo_gl.scene.material import Color
from ssdo_gl.scene.motion import Motion

Vector = tuple[float, float, float]
# map: shadow map (or shadow rays); ssdo: arrives through SSDO's open directions
# and is part of `directional`, not of `direct`; none: casts no shadow.
Shadow = Literal["map", "ssdo", "none"]


@dataclass(frozen=True)
class PointLight:
    """An isotropic point light; `intensity` in W/sr per colour channel."""

    position: Vector
    intensity: Color
    shadow: Shadow = "map"
    name: str = ""
    motion: Motion | None = None


@dataclass(frozen=True)
class SpotLight:
    """A point light inside a cone around `direction` (world space, unit length).

    `intensity` (W/sr) holds within `inner_angle`, falls smoothly to zero at
    `outer_angle` (half-angles in degrees, 0 <= inner < outer < 90) by glTF's
    KHR_lights_punctual rule: the squared, clamped linear ramp in the cosine.
    """

    position: Vector
    direction: Vector
    intensity: Color
    inner_angle: float = 0.0
    outer_angle: float = 45.0
    shadow: Shadow = "map"
    name: str = ""
    motion: Motion | None = None


@dataclass(frozen=True)
class DirectionalLight:
    """Parallel light travelling along `direction` (world space, unit length).

    `irradiance` is what a surface facing the light receives, W/m^2.
    """

    direction: Vector
    irradiance: Color
    shadow: Shadow = "map"
    name: str = ""
    motion: Motion | None = None


@dataclass(frozen=True)
class RectangleLight:
    """A one-sided parallelogram emitter; emits along edge_u x edge_v.

    Attributes
    ----------
    corner, edge_u, edge_v : Vector
        World space, scene units. The four corners are corner, + edge_u,
        + edge_u + edge_v, + edge_v.
    radiance : Color
        W sr^-1 m^-2.
    visible : bool
        Whether the camera sees it as an emitter and it blocks rays. A visible
        rectangle is drawn by geometry that the Scene carries for it.
    two_sided : bool
        Whether the other side emits too (for emissive meshes that ask for it).
    """

    corner: Vector
    edge_u: Vector
    edge_v: Vector
    radiance: Color
    shadow: Shadow = "map"
    visible: bool = True
    two_sided: bool = False
    name: str = ""
    motion: Motion | None = None


Light = PointLight | SpotLight | DirectionalLight | RectangleLight


def power(light: Light) -> float:
    """Return the largest component of what the light emits, in the unit of its kind."""
    return max(emitted(light))


def emitted(light: Light) -> Color:
    """Return what the light emits, in the unit of its kind."""
    if isinstance(light, RectangleLight):
        return light.radiance
    if isinstance(light, DirectionalLight):
        return light.irradiance
    return light.intensity
