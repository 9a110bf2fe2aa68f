"""Sheets seen from one side stop lamps alike, however rays find these."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest
import scene_text as text

from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings.settings import Settings

# Means have noise of up to .02. While rays by chance met other sides than rays drawn to lamps,
# paths let .06 to .62 of the light past the sheet that looks down, by the number of lamps, and .37
# to .93 past the one that looks up; of gi's lobes .92 and .08.
OPEN_BOUND, SHUT_BOUND = 0.05, 1e-6
SHEETS = {"up": ([-3, 1, 3], [6, 0, 0], [0, 0, -6]), "down": ([-3, 1, -3], [6, 0, 0], [0, 0, 6])}
# Each as bright as the lamp, and never seen: the more, the rarer rays are drawn to the lamp.
FAR = [text.quad([-1, -500 - n, -1], [0, 0, 3], [3, 0, 0], "lamp") for n in range(3)]
PANEL = text.quad([-1.5, 1.5, -1.5], [3, 0, 0], [0, 0, 3], "lamp")
BALL = text.ball([0, 1.9, 0], 0.8, "lamp")
GLOSSY = {"roughness": 0.2, "specular": 1.0}


def room(folder: Path, lamps: str, facing: str | None, **floor: float) -> Scene:
    """Return a lamp over a floor, and a sheet between them that shows its front alone."""
    (folder / "room.toml").write_text(
        text.camera([0, 0.8, 1.2], [0, 0, 0], 60)
        + text.material("floor", 0.2, 0.2, 0.2, **floor)
        + text.material("sheet", 0.01, 0.01, 0.01)
        + text.material("lamp", 0, 0, 0, emission=[4, 4, 4])
        + text.box([-2, -0.2, -2], [2, 0, 2], "floor")
        + lamps
        + ("" if facing is None else text.quad(*SHEETS[facing], "sheet"))
    )
    scene = load_scene(folder / "room.toml")
    materials = [
        dataclasses.replace(material, single_sided=material.name == "sheet")
        for material in scene.materials
    ]
    return dataclasses.replace(scene, materials=tuple(materials))


def light(scene: Scene, method: str) -> float:
    settings = Settings(method, size=(32, 18), spp=1024, shadow_rays=256, radius=100.0, antialias=4)
    with Renderer(scene, settings) as renderer:
        return float(renderer.render(("beauty",)).images["beauty"][..., :3].mean())


@pytest.mark.parametrize(
    ("method", "lamp", "floor"),
    [
        ("reference-gi", PANEL, {}),
        ("reference-gi", BALL, GLOSSY),
        ("reference-near", PANEL, GLOSSY),
        ("gi", BALL, GLOSSY),
    ],
    ids=["paths", "paths of gloss", "shadow rays", "gi"],
)
def test_what_faces_the_lamp_stops_its_light_however_often_rays_are_drawn_to_it(
    tmp_path: Path, method: str, lamp: str, floor: dict[str, float]
) -> None:
    bare = light(room(tmp_path, lamp, None, **floor), method)
    for lamps in (lamp, lamp + "".join(FAR)):
        past = light(room(tmp_path, lamps, "down", **floor), method)
        assert past == pytest.approx(bare, rel=OPEN_BOUND)
        assert light(room(tmp_path, lamps, "up", **floor), method) <= SHUT_BOUND * bare
