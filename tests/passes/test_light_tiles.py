"""Tiles that a light reaches whole or not at all: the same picture as pixel by pixel."""

from __future__ import annotations

import dataclasses
from contextlib import ExitStack

import numpy as np
import pytest

from ssdo_gl import Renderer
from ssdo_gl.gpu.context import draws_on_cpu
from ssdo_gl.options.resolve import settings_for
from ssdo_gl.passes import light_tiles
from ssdo_gl.passes.light_draws import DARK, MIXED, OPEN
from ssdo_gl.scene.lights import DirectionalLight, PointLight, RectangleLight, SpotLight
from ssdo_gl.scene.load import load_scene
from ssdo_gl.shared_scene import SharedScene

# Neither a multiple of a tile.
SIZE = (330, 190)
SUN = (-0.6, -1.0, -0.5)
WHITE = (1.0, 1.0, 1.0)
# In the corner of a room that is two units wide.
LAMP = PointLight((0.5, 1.2, 0.5), WHITE, shadow="map")
SPOT = SpotLight((0.5, 1.5, 0.5), (-0.3, -1.0, -0.4), WHITE, outer_angle=50.0, shadow="map")
PANEL = RectangleLight((0.2, 1.5, 0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.3), WHITE, shadow="map")
CASES = {
    "point": ("corner", (LAMP,)),
    "spot": ("corner", (SPOT,)),
    "rectangle": ("corner", (PANEL,)),
    "two-sided": ("corner", (dataclasses.replace(PANEL, two_sided=True),)),
    "sun": ("stairs", (DirectionalLight(SUN, WHITE, shadow="map"),)),
    "soft sun": ("stairs", (DirectionalLight(SUN, WHITE, angle=1.0, shadow="map"),)),
    "several": ("stairs", (DirectionalLight(SUN, WHITE, shadow="map"), LAMP, PANEL)),
}


@pytest.fixture
def told(device, monkeypatch):
    """The tiles of each draw, as they are told apart whether it pays or not."""
    if not draws_on_cpu(device.gl):
        pytest.skip("only processors draw tiles")
    tiles = []
    tell = light_tiles._Telling.tell

    def recorded(self, *given):
        tell(self, *given)
        tiles.append(np.frombuffer(self.tiles.read(), np.float32).copy())

    monkeypatch.setattr(light_tiles._Telling, "tell", recorded)
    monkeypatch.setattr(light_tiles, "LEAST_TOLD", (0.0, 0.0))
    return tiles


def drawn_both_ways(device, scene, monkeypatch):
    """Direct light by tiles, and pixel by pixel."""
    settings = settings_for(scene.render, {"size": SIZE, "method": "direct"})
    x, y, z = scene.camera.position
    aside = dataclasses.replace(scene.camera, position=(x + 1e-3, y, z))
    images = []
    with Renderer(scene, settings, device=device) as renderer:
        # Maps are looked at in quads, and tiles by them, from the second time on.
        for least in (light_tiles.LEAST_TILES, 10**9):
            monkeypatch.setattr(light_tiles, "LEAST_TILES", least)
            renderer.render(["direct"], camera=aside)
            images.append(renderer.render(["direct"]).images["direct"])
    return images


@pytest.mark.parametrize("height", [None, 2.0], ids=["perspective", "parallel"])
@pytest.mark.parametrize("case", CASES)
def test_tiles_show_what_pixels_find(device, monkeypatch, told, case, height):
    name, lights = CASES[case]
    scene = load_scene(name)
    camera = dataclasses.replace(scene.camera, height=height)
    scene = dataclasses.replace(scene, lights=lights, camera=camera)
    tiled, plain = drawn_both_ways(device, scene, monkeypatch)
    assert plain.max() > 0.0
    np.testing.assert_array_equal(tiled, plain)
    kinds = set(np.concatenate(told))
    assert kinds <= {DARK, OPEN, MIXED}
    assert MIXED in kinds
    assert len(kinds) > 1 if height else OPEN in kinds


def test_light_that_grazes_vaults_is_what_pixels_find(device, monkeypatch, told):
    """There pixels may find the map in their own plane, although all of it is before them."""
    tiled, plain = drawn_both_ways(device, load_scene("colonnade"), monkeypatch)
    assert DARK in set(np.concatenate(told))
    np.testing.assert_array_equal(tiled, plain)


def test_views_of_two_sizes_are_told_apart_each_by_what_it_found(device, monkeypatch, told):
    """To begin anew is to wait for the device in each frame."""
    scene = load_scene("stairs")
    shared = SharedScene(device.gl, scene)
    made, first = [], light_tiles._Telling.__init__

    def counted(self, gl, blocks, size):
        made.append(size)
        first(self, gl, blocks, size)

    monkeypatch.setattr(light_tiles._Telling, "__init__", counted)
    x, y, z = scene.camera.position
    with ExitStack() as opened:
        views = []
        for size in (SIZE, (400, 240)):
            settings = settings_for(scene.render, {"size": size, "method": "direct"})
            view = Renderer(scene, settings, device=device, shared=shared)
            views.append(opened.enter_context(view))
        for i in range(4):
            camera = dataclasses.replace(scene.camera, position=(x + 1e-3 * i, y, z))
            for view in views:
                view.render(["direct"], camera=camera)
    assert len(told) == 6
    assert made == [(21, 12), (25, 15)]
