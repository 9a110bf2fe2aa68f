"""Light for a scene that brings none of its own."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment import (
    GradientEnvironment,
    MapEnvironment,
    sun_apart,
    sun_note,
    texels,
    turned_sun,
)
from ssdo_gl.scene.files import read_radiance_map
from ssdo_gl.scene.lights import DirectionalLight, Light
from ssdo_gl.scene.material import Color

# A white surface that faces the key light reaches (pi 0.32 + 2.15) / pi = 1.0, and one
# that sees the sky alone 0.3: the range of a picture at exposure 0, with shape in it.
SKY = GradientEnvironment(
    zenith=(0.34, 0.40, 0.50), horizon=(0.30, 0.30, 0.31), ground=(0.15, 0.135, 0.12)
)
KEY_IRRADIANCE = (2.3, 2.15, 1.95)
# Where the key light stands as seen from the camera: to the left, high, in front.
KEY_LEFT_DEGREES, KEY_UP_DEGREES = 40.0, 50.0


# Radius of the near field relative to the diagonal. Against full transport, relMSE of the
# bounce is least there: 0.0019 for Fox, 0.0026 for knight, 0.0017 for bunny at 0.32 (0.0051,
# 0.0089, 0.0040 at 0.08); 0.12 in the Cornell box at 0.64 (0.23 at 0.08).
MODEL_REACH, ROOM_REACH = 0.32, 0.64

# EV by which pictures in such light may be darker or brighter than the usual, as things are.
METERING_SLACK = 1.5

# A hierarchy for rays takes some 10 us a triangle, of bodies that move for every frame. Scenes
# of more triangles ask for a method that needs none: it would take more than 20 s, or 1 s.
MOST_TRACED, MOST_TRACED_MOVING = 2_000_000, 100_000
RAYLESS_METHOD = "bounce"

# Of a file that has lamps and no sky: relative to the radiance of what the lamps light,
# so that shadows are three stops below it. Skylight is about a fifth of sunlight.
NEUTRAL_SKY = GradientEnvironment(zenith=(0.18,) * 3, horizon=(0.15,) * 3, ground=(0.08,) * 3)

# What is seen of it is its light on things; behind them an even grey, as of the ground.
STUDIO, BACKDROP = "studio", (0.28, 0.28, 0.28)
# Of the studio's map: 1.4 degrees a texel.
_STUDIO_ROWS, _STUDIO_COLUMNS = 128, 256
_STUDIO_KEY_IRRADIANCE = (1.03, 1.0, 0.97)
_STUDIO_ZENITH, _STUDIO_HORIZON, _STUDIO_FLOOR = 0.22, 0.34, 0.10


@dataclass(frozen=True)
class _SoftBox:
    """A bright rectangle of the studio, as seen from the model.

    Attributes
    ----------
    left_degrees, up_degrees : float
        Where its middle stands: to the left of the camera's side of the model, and up.
    half_size : (float, float)
        Tangents of half its width and height.
    """

    left_degrees: float
    up_degrees: float
    half_size: tuple[float, float]
    radiance: float

    def glow(self, directions: FloatArray, axes: FloatArray) -> FloatArray:
        """Return radiance (...) along unit `directions` (..., 3); soft at its edges."""
        middle = _direction(axes, self.left_degrees, self.up_degrees)
        across = math3d.normalized(np.cross(axes[1], middle))
        forward = directions @ middle
        is_ahead = forward > 0.05
        tangents = np.stack([directions @ across, directions @ np.cross(middle, across)], axis=-1)
        part = np.abs(tangents / np.where(is_ahead, forward, 1.0)[..., None]) / self.half_size
        inside = np.clip((1.15 - part) / 0.3, 0.0, 1.0).min(axis=-1)
        smooth = inside * inside * (3.0 - 2.0 * inside)
        return np.asarray(np.where(is_ahead, self.radiance * smooth, 0.0))


# A large one beside the key light, a tall one opposite, a rim behind and one overhead:
# rounded metal shows a bright edge on either side and a horizon between.
_SOFT_BOXES = (
    _SoftBox(KEY_LEFT_DEGREES, 42.0, (0.42, 0.34), 2.6),
    _SoftBox(-65.0, 12.0, (0.20, 0.80), 1.5),
    _SoftBox(155.0, 35.0, (0.80, 0.20), 2.4),
    _SoftBox(0.0, 82.0, (0.55, 0.55), 0.8),
)


def soft_light(camera: Camera) -> tuple[GradientEnvironment, DirectionalLight]:
    """Return a soft sky and one key light that suits the camera's point of view."""
    return SKY, _key_light(camera, KEY_IRRADIANCE)


def studio(camera: Camera) -> tuple[MapEnvironment, DirectionalLight]:
    """Return a room of soft boxes around the camera's point of view, and a key light."""
    directions, _ = texels(_STUDIO_ROWS, _STUDIO_COLUMNS)
    up = directions[..., 1]
    end = np.where(up >= 0.0, _STUDIO_ZENITH, _STUDIO_FLOOR)
    radiance = _STUDIO_HORIZON + (end - _STUDIO_HORIZON) * np.minimum(np.abs(up) * 3.0, 1.0)
    axes = _axes(camera)
    radiance = radiance + sum(box.glow(directions, axes) for box in _SOFT_BOXES)
    image = np.repeat(radiance[:, :, None], 3, axis=2).astype(np.float32)
    return MapEnvironment(image, name=STUDIO), _key_light(camera, _STUDIO_KEY_IRRADIANCE)


def _key_light(camera: Camera, irradiance: Color) -> DirectionalLight:
    x, y, z = -_direction(_axes(camera), KEY_LEFT_DEGREES, KEY_UP_DEGREES)
    return DirectionalLight((float(x), float(y), float(z)), irradiance, name="key light")


def _axes(camera: Camera) -> FloatArray:
    """Return as rows: level towards the camera, up, and to the left of the camera."""
    up = np.array([0.0, 1.0, 0.0])
    toward_camera = np.subtract(camera.position, camera.target)
    level = toward_camera - up * toward_camera[1]
    if np.linalg.norm(level) < 1e-6 * np.linalg.norm(toward_camera):
        level = np.array([0.0, 0.0, 1.0])  # the camera looks straight down or up
    front = math3d.normalized(level)
    return np.stack([front, up, np.cross(front, up)])


def _direction(axes: FloatArray, left_degrees: float, up_degrees: float) -> FloatArray:
    front, up, left = axes
    azimuth, elevation = np.radians([left_degrees, up_degrees])
    level = np.cos(azimuth) * front + np.sin(azimuth) * left
    return np.asarray(np.cos(elevation) * level + np.sin(elevation) * up)


def image_light(path: str | Path) -> tuple[MapEnvironment, list[Light], list[str]]:
    """Return the environment of an image, its sun, if it has one, and what to say of both.

    Raises
    ------
    SceneError
        If it cannot be read.
    """
    image, note = read_radiance_map(Path(path), f"light = {path}", 1.0)
    environment = sun_apart(image, 0.0, Path(path).name)
    suns = [light for light in (turned_sun(environment),) if light is not None]
    return environment, [*suns], [text for text in (note, sun_note(environment)) if text]
