"""Rays aimed at windows find the sky that others seldom meet, and no more of it."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
import scene_text as text

from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings.settings import Settings

SIZE = (48, 27)
NONE = {"far_field.aimed_rays": 0}
SKY = {
    "constant": text.constant_sky(4, 5, 6),
    "gradient": text.table(
        "environment", kind="gradient", zenith=[2, 3, 6], horizon=[6, 6, 6], ground=[2, 1, 1]
    ),
    "sky": text.table("environment", kind="sky", hour=9, north=200),
}
# A room of 4 x 2.5 x 6, and a window of .7 x .5 high in its far wall.
WALLS = (
    ([-2.1, -0.1, -3.1], [2.1, 0, 3.1]),
    ([-2.1, 2.5, -3.1], [2.1, 2.6, 3.1]),
    ([-2.1, 0, -3.1], [-2, 2.5, 3.1]),
    ([2, 0, -3.1], [2.1, 2.5, 3.1]),
    ([-2, 0, 3], [2, 2.5, 3.1]),
    ([-2, 0, -3.1], [2, 1.6, -3]),
    ([-2, 2.1, -3.1], [2, 2.5, -3]),
    ([-2, 1.6, -3.1], [-0.1, 2.1, -3]),
    ([0.6, 1.6, -3.1], [2, 2.1, -3]),
)
ROOM = (
    text.camera([1.2, 1.5, 2.6], [-0.3, 0.9, -2], 60)
    + text.material("white", 0.6, 0.6, 0.6)
    + text.box([-0.6, 0, -0.7], [0.1, 0.9, 0], "white")
    + "".join(text.box(low, high, "white") for low, high in WALLS)
)


def room(sky: str) -> Scene:
    return read_description(SKY[sky] + ROOM, "room")


def pictures(scene: Scene, method: str = "gi", seeds: int = 4, **fields: Any) -> np.ndarray:
    """Return pictures (seeds, height, width, 3) of `scene`."""
    settings = Settings(method=method, size=SIZE, radius=0.1, **fields)
    found = []
    with Renderer(scene, settings) as renderer:
        for seed in range(seeds):
            renderer.use(dataclasses.replace(settings, seed=seed))
            found.append(renderer.render(("beauty",)).images["beauty"][..., :3])
    return np.array(found)


@pytest.mark.parametrize("sky", sorted(SKY))
def test_they_find_as_much_with_less_noise(sky: str) -> None:
    scene = room(sky)
    aimed, chance = pictures(scene), pictures(scene, overrides=NONE)
    assert aimed.std(axis=0).mean() < 0.6 * chance.std(axis=0).mean()
    paths = pictures(scene, "reference-gi", 1, spp=1024)
    # What the paths leave is 1 %.
    is_room = paths.max(axis=(0, 3)) < 0.5 * paths.max()
    assert aimed[:, is_room].mean() == pytest.approx(paths[:, is_room].mean(), rel=0.03)


def test_where_no_wall_has_a_window_pictures_are_the_same_to_the_bit() -> None:
    yard = text.box([-0.6, 0, -0.7], [0.1, 0.9, 0], "white") + text.floor(6, "white")
    scene = read_description(SKY["constant"] + ROOM.partition("[[object]]")[0] + yard, "yard")
    np.testing.assert_array_equal(
        pictures(scene, seeds=1), pictures(scene, seeds=1, overrides=NONE)
    )


def test_a_walk_is_as_bright_as_a_view_at_rest() -> None:
    # Of 1.3 by 1.1.
    wider = ROOM.replace("1.6", "1.0").replace("-0.1, 2.1", "-0.7, 2.1")
    scene, frames = read_description(SKY["sky"] + wider, "wider"), []
    with Renderer(scene, Settings(method="gi", size=SIZE, radius=0.1)) as renderer:
        for step in range(-23, 1):
            drawn = renderer.draw(("beauty",), camera=scene.camera.orbit(0.2 * step))
            frames.append(drawn.planes["beauty"].read()[..., :3].mean())
    at_rest = pictures(scene, overrides={"far_field.aimed_rays": 16})
    assert frames[-1] == pytest.approx(at_rest.mean(), rel=0.01)
