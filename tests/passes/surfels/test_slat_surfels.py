"""Light that goes through a louvre from slat to slat is as by surfels much finer than slats.

What slats see of each other is found by `passes/surfel_surroundings.frag`.
"""

from __future__ import annotations

import numpy as np
import pytest
from passes.cache_harness import fill

from ssdo_gl import math3d
from ssdo_gl.passes.surfels.surfel_textures import SurfaceCacheSettings
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.geometry.shapes import box
from ssdo_gl.scene.lights import PointLight
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

# Of a slat: how thick, wide and long it is; what they are apart.
SIZE, PITCH, COUNT = (0.005, 0.1, 1.0), 0.08, 15
WHITE, BLACK = Material(albedo=(0.8, 0.8, 0.8)), Material(albedo=(0.0, 0.0, 0.0))
CAMERA = Camera((2.0, 0.6, 0.0), (0.0, 0.6, 0.0))


def louvre(room: float | None = None) -> Scene:
    """Return slats that lean away from a lamp, and a plate behind them; in a room, or alone."""
    slat = math3d.rotation_euler([0.0, 0.0, -45.0]) @ math3d.scaling(SIZE)
    places = [math3d.translation([0.0, PITCH * i, 0.0]) @ slat for i in range(COUNT)]
    plate = math3d.translation([0.5, 0.4, 0.0]) @ math3d.scaling([0.01, 0.6, 0.4])
    black = [plate] if room is None else [plate, math3d.scaling(room)]
    objects = SceneObject(0, 0, np.array(places)), SceneObject(0, 1, np.array(black))
    light = PointLight((-1.0, 1.5, 0.0), (10.0, 10.0, 10.0))
    return Scene((box(),), (WHITE, BLACK), objects, CAMERA, (light,))


def test_as_much_light_comes_through_as_by_fine_surfels(device, shaders) -> None:
    """A black room changes nothing but the size of surfels."""
    means = []
    for scene, most in ((louvre(room=4.0), 3000), (louvre(), 32768)):
        filled = fill(device, shaders, scene, SurfaceCacheSettings(surfels=most))
        x, y, z = np.abs(filled.positions).T
        on_plate = (x > 0.49) & (x < 0.495) & (y < 0.7) & (z < 0.2)
        assert np.all(filled.direct[on_plate] == 0.0)
        means.append(filled.irradiance[on_plate, 0].mean())
    assert means[0] == pytest.approx(means[1], rel=0.1)
