"""What gloss costs: processor time of frames, interleaved with those of the same scene without."""

from __future__ import annotations

import statistics

import pytest

from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.settings import Settings

SCENE = """
[camera]
position = [0, 1, 4]
target = [0, 0.4, 0]
fov_y = 40
[render]
radius = 1.0
[materials.floor]
albedo = [0.7, 0.5, 0.3]
FLOOR
[materials.ball]
albedo = [1, 0.8, 0.4]
BALL
[[object]]
shape = "quad"
corner = [-50, 0, 50]
edge_u = [100, 0, 0]
edge_v = [0, 0, -100]
material = "floor"
[[object]]
shape = "sphere"
PLACE
material = "ball"
[[light]]
kind = "area"
corner = [-0.5, 2.5, -0.5]
edge_u = [1, 0, 0]
edge_v = [0, 0, 1]
radiance = [8, 8, 8]
[environment]
kind = "gradient"
zenith = [0.4, 0.5, 0.8]
horizon = [0.8, 0.8, 0.8]
ground = [0.1, 0.1, 0.1]
"""
BEHIND = "center = [0, 0.6, 9]\nradius = 0.6"
SMALL = "center = [0, 0.25, 1]\nradius = 0.22"
METAL = "metallic = 1\nroughness = 0.2"
ROUNDS = 5


def scene_of(place, ball="", floor=""):
    text = SCENE.replace("PLACE", place).replace("BALL", ball).replace("FLOOR", floor)
    return read_description(text, "scene.toml")


@pytest.mark.slow
def test_gloss_costs_by_what_is_seen_of_it(device, shaders):
    scenes = {
        "without": scene_of(SMALL), "small": scene_of(SMALL, METAL),
        "all": scene_of(SMALL, METAL, "roughness = 0.3"),
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
