"""Rays aimed at small bright pieces of surface find what others seldom meet, and no more of it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import scene_text as text

from ssdo_gl.effects import moving_light
from ssdo_gl.graph.render_pass import PassContext, Produced
from ssdo_gl.passes.surfels import BrightTablesPass
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings.settings import Settings

SIZE = (64, 36)
SEEDS = 4
FRAMES = 24
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


def walked(scene: Scene, aimed_rays: int) -> np.ndarray:
    """Return the last frame of a camera that turns, as a window draws it."""
    overrides = {"far_field.aimed_rays": aimed_rays}
    settings = Settings(method="gi", size=SIZE, radius=0.1, overrides=overrides)
    with Renderer(scene, settings) as renderer:
        for step in range(FRAMES):
            camera = scene.camera.orbit(0.2 * (step - FRAMES + 1))
            drawn = renderer.draw(("beauty",), camera=camera)
        return drawn.planes["beauty"].read()[..., :3].copy()


@pytest.mark.parametrize("description", [BENCH, BALL], ids=["flat", "curved"])
def test_a_walk_is_nearer_to_a_view_at_rest_by_them(
    description: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Averages over pixels in the same light would make both alike.
    monkeypatch.setattr(moving_light, "STEPS", ())
    monkeypatch.setattr(moving_light, "UNEVEN_STEPS", ())
    scene = room(description)
    settings = Settings(method="gi", size=SIZE, radius=0.1, overrides={"far_field.pixel_rays": 128})
    with Renderer(scene, settings) as renderer:
        rest = renderer.render(("beauty",)).images["beauty"][..., :3]
    aimed, chance = (np.abs(walked(scene, rays) - rest).mean() for rays in (4, 0))
    assert aimed < 0.5 * chance


def test_they_follow_a_light_that_has_moved(monkeypatch: pytest.MonkeyPatch) -> None:
    pieces: list[set[int]] = []
    original = BrightTablesPass.execute

    def noted(item: BrightTablesPass, context: PassContext) -> Produced:
        made = original(item, context)
        aims = made["bright_entries"].facts
        pieces.append(set(aims.pieces.surfels.tolist()))
        return made

    monkeypatch.setattr(BrightTablesPass, "execute", noted)
    scene = room(BENCH)
    (spot,) = scene.lights
    moved = dataclasses.replace(spot, position=(1.2, 1.6, 0.5))
    with Renderer(scene, Settings(method="gi", size=SIZE, radius=0.1)) as renderer:
        renderer.draw(("beauty",), camera=scene.camera)
        renderer.use_scene(dataclasses.replace(scene, lights=(moved,)))
        for _ in range(FRAMES):
            renderer.draw(("beauty",), camera=scene.camera)
    assert pieces[0] and pieces[-1] and not pieces[0] & pieces[-1]
    # While light is spreading they are chosen by what it was.
    assert pieces[1] == pieces[0]
