"""Parallel light with an angle arrives through SSDO's open directions over all of its disk."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry import shapes
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.lights import DirectionalLight
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

# Noise of 8 directions in the penumbra, .0275; looked for along its middle alone: .043.
RMSE = 0.033


def wall_on_a_floor(angle):
    floor = np.diag([20.0, 20.0, 1.0, 1.0])
    floor = np.array([[1, 0, 0, -10], [0, 0, 1, 0], [0, -1, 0, 10], [0, 0, 0, 1.0]]) @ floor
    wall = np.diag([0.3, 1.2, 1.2, 1.0])
    wall[:3, 3] = (0.35, 0.6, 0.0)
    light = DirectionalLight(
        (-np.sqrt(0.5), -np.sqrt(0.5), 0.0), (3.0, 3.0, 3.0), shadow="ssdo", angle=angle
    )
    meshes = (shapes.quad(), shapes.box())
    objects = (SceneObject(0, 0, floor[None]), SceneObject(1, 0, wall[None]))
    return Scene(meshes, (Material(),), objects, Camera((0, 3, 4), (0, 0.3, 0)), (light,))


def directional(device, shaders, scene, **settings):
    settings = Settings(size=(96, 54), radius=3.0, **settings)
    with Renderer(scene, settings, device=device, shaders=shaders) as renderer:
        return renderer.render(["directional"]).images["directional"][..., :3]


@pytest.mark.parametrize("effects", ["auto", "full"])
def test_the_penumbra_is_that_of_rays(device, shaders, effects):
    scene = wall_on_a_floor(30.0)
    rays = directional(device, shaders, scene, method="reference-near", spp=256)
    found = directional(device, shaders, scene, method="ssdo", effects=effects)
    error = float(np.sqrt(np.mean((found - rays) ** 2)) / rays.mean())
    assert error < RMSE


def test_a_sharp_light_is_looked_for_once(device, shaders):
    """An angle next to nothing casts the shadow of no angle."""
    sharp, narrow = (
        directional(device, shaders, wall_on_a_floor(angle), method="ssdo") for angle in (0.0, 1e-3)
    )
    assert np.mean(np.abs(narrow - sharp)) < 0.01 * sharp.mean()
