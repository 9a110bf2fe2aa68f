"""Rays aimed at small bright pieces of surface find what others seldom meet, and no more of it."""

from __future__ import annotations

import numpy as np
import pytest
import scene_text as text

from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings.settings import Settings

SIZE = (64, 36)
SEEDS = 4
ROOM = (
    text.camera([0, 1.5, 2.6], [0, 1.2, -2], 60)
    + text.material("white", 0.7, 0.7, 0.7)
    + text.box([-2, 0, -3], [2, 2.5, 3], "white")
    + text.light(
        "spot",
        position=[0, 1.6, -1],
        direction=[0, -1, 0],
        intensity=[60, 60, 60],
        inner_angle=6,
        outer_angle=8,
    )
)
BENCH = ROOM + text.box([-0.3, 0, -1.3], [0.3, 0.8, -0.7], "white")
BALL = ROOM + text.ball([0, 1, -1], 0.15, "white")


def room(description: str) -> Scene:
    return read_description(description, "room")


def pictures(scene: Scene, aimed_rays: int, rays: int = 6) -> np.ndarray:
    """Return what light from beyond R brings, (SEEDS, height, width, 3)."""
    overrides = {
        "far_field.aimed_rays": aimed_rays,
        "far_field.pixel_rays": rays,
        "far_field.edge_rays": max(rays, 16),
    }
    found = []
    for seed in range(SEEDS):
        settings = Settings(method="gi", size=SIZE, radius=0.1, seed=seed, overrides=overrides)
        with Renderer(scene, settings) as renderer:
            found.append(renderer.render(("directional",)).images["directional"])
    return np.array(found)


@pytest.mark.parametrize("description", [BENCH, BALL], ids=["flat", "curved"])
def test_they_find_as_much_with_less_noise(description: str) -> None:
    scene = room(description)
    aimed, chance, many = pictures(scene, 4), pictures(scene, 0), pictures(scene, 0, 256)
    # What four pictures by 256 rays leave is 1.1 %.
    assert aimed.mean() == pytest.approx(many.mean(), rel=0.03)
    assert aimed.std(axis=0).mean() < 0.7 * chance.std(axis=0).mean()


def test_rooms_in_even_light_are_the_same_to_the_bit() -> None:
    even = text.light("point", position=[0, 1.2, 0], intensity=[1, 1, 1])
    scene = room(ROOM.partition("[[light]]")[0] + even)
    np.testing.assert_array_equal(pictures(scene, 4), pictures(scene, 0))
