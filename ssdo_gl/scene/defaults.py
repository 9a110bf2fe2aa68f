"""Light for a scene that brings none of its own."""

from __future__ import annotations

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment_kinds import GradientEnvironment
from ssdo_gl.scene.lights import DirectionalLight

# A white surface that faces the key light reaches (pi 0.32 + 2.15) / pi = 1.0, and one
# that sees the sky alone 0.3: the range of a picture at exposure 0, with shape in it.
SKY = GradientEnvironment(
    zenith=(0.34, 0.40, 0.50), horizon=(0.30, 0.30, 0.31), ground=(0.15, 0.135, 0.12)
)
KEY_IRRADIANCE = (2.3, 2.15, 1.95)
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
    return SKY, DirectionalLight((x, y, z), KEY_IRRADIANCE, name="key light")
