"""Light for a scene that brings none of its own."""

from __future__ import annotations

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment import GradientEnvironment
from ssdo_gl.scene.light import DirectionalLight

# A white surface that faces the key light reaches (pi * 0.45 + 1.6) / pi = 0.96, and
# one lit by the sky alone about 0.4: the whole range fits a picture at exposure 0.
SKY = GradientEnvironment(
    zenith=(0.5, 0.56, 0.66), horizon=(0.42, 0.42, 0.42), ground=(0.2, 0.18, 0.16)
)
KEY_IRRADIANCE = (1.75, 1.65, 1.5)
# Where the key light stands as seen from the camera: to the left, high, in front.
KEY_LEFT_DEGREES, KEY_UP_DEGREES = 40.0, 50.0


def soft_light(camera: Camera) -> tuple[GradientEnvironment, DirectionalLight]:
    """Return a soft sky and one key light that suits the camera's point of view."""
    up = np.array([0.0, 1.0, 0.0])
    toward_camera = np.subtract(camera.position, camera.target)
    level = toward_camera - up * toward_camera[1]
    if np.linalg.norm(level) < 1e-6 * np.linalg.norm(toward_camera):
        level = np.array([0.0, 0.0, 1.0])  # the camera looks straight down or up
    front = math3d.normalized(level)
    left = np.cross(front, up)
    azimuth, elevation = np.radians([KEY_LEFT_DEGREES, KEY_UP_DEGREES])
    toward_light = (
        np.cos(elevation) * (np.cos(azimuth) * front + np.sin(azimuth) * left)
        + np.sin(elevation) * up
    )
    x, y, z = (float(value) for value in -toward_light)
    return SKY, DirectionalLight((x, y, z), KEY_IRRADIANCE, "map", "key light")
