"""What gloss costs: processor time of frames, interleaved with those of the same scene without."""

from __future__ import annotations

import statistics

import pytest
from effects.glossy_floor import FLOOR, GRADIENT
from scene_text import ball, camera, lamp, material, table

from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.settings import Settings

REST = (
    camera([0, 1, 4], [0, 0.4, 0], 40)
    + table("render", radius=1.0)
    + FLOOR
    + lamp([-0.5, 2.5, -0.5], [1, 0, 0], [0, 0, 1], [8, 8, 8])
    + GRADIENT
)
BEHIND = ball([0, 0.6, 9], 0.6, "ball")
SMALL = ball([0, 0.25, 1], 0.22, "ball")
METAL = {"metallic": 1, "roughness": 0.2}
ROUNDS = 5


def scene_of(placed, finish=(), **floor):
    text = REST + placed + material("ball", 1, 0.8, 0.4, **dict(finish))
    return read_description(text + material("floor", 0.7, 0.5, 0.3, **floor), "scene.toml")


@pytest.mark.slow
def test_gloss_costs_by_what_is_seen_of_it(device, shaders):
    scenes = {
        "without": scene_of(SMALL), "small": scene_of(SMALL, METAL),
        "all": scene_of(SMALL, METAL, roughness=0.3),
        "without, behind": scene_of(BEHIND), "behind": scene_of(BEHIND, METAL),
    }  # fmt: skip
    settings = Settings("bounce", size=(320, 180))
    drawn = {
        name: Renderer(scene, settings, device=device, shaders=shaders)
        for name, scene in scenes.items()
    }
    times = {name: [] for name in scenes}
    for number in range(ROUNDS):
        for name, renderer in drawn.items():
            milliseconds = renderer.render(("beauty",), frames=2).process_ms
            times[name] += milliseconds if number else []
    median = {name: statistics.median(values) for name, values in times.items()}
    # A tenth of noise; where gloss is not seen, nothing of it runs.
    assert median["behind"] < 1.1 * median["without, behind"]
    assert median["small"] < 1.15 * median["without"]
    assert median["small"] < 0.85 * median["all"]
