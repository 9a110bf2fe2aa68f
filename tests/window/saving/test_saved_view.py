"""What was edited lasts: scene files and commands render the picture that was seen."""

from __future__ import annotations

import dataclasses
import json
import shlex
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from window.driven_viewer import FRAME_S, ROUNDING, SIZE, ask, said, settle

from ssdo_gl import math3d
from ssdo_gl.cli import main
from ssdo_gl.scene.environment.environment_kinds import GradientEnvironment
from ssdo_gl.scene.light_edits import moved_lights, new_light
from ssdo_gl.scene.lights import KINDS
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.material_edits import edited_material
from ssdo_gl.window.camera.controls import Controls
from ssdo_gl.window.input.bindings import Command
from ssdo_gl.window.opening.opened import open_file
from ssdo_gl.window.viewer import Viewer

TRIANGLES = "v -1 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n"
SKY = GradientEnvironment((0.1, 0.3, 0.9), (0.4, 0.4, 0.4), (0.2, 0.1, 0.0))


@pytest.fixture(params=["cornell_meso", "model"])
def viewer(request, make_viewer, tmp_path: Path) -> Viewer:
    source = request.param
    if source == "model":
        source = str(tmp_path / "model.obj")
        Path(source).write_text(TRIANGLES)
    # As the program loads it: with a ground under a model.
    return make_viewer(source, ground="auto")


def paint(viewer: Viewer) -> None:
    """Let the first thing of the scene be of another colour, and glow."""
    index = next(item.material for item in viewer.original.objects if item.light is None)
    colors = {"albedo": (0.1, 0.7, 0.3), "emission": (0.0, 0.1, 0.4)}
    viewer.change_material(index, edited_material(viewer.original.materials[index], colors))


def edit(viewer: Viewer) -> None:
    """Turn a light, bring a sky, change what is seen, go for a walk, change settings."""
    paint(viewer)
    light = viewer.lights[0]
    viewer.lights[0] = light.with_emitted((2.0, 1.0, 0.5))
    viewer.original = dataclasses.replace(viewer.original, environment=SKY)
    # One turned, one copied and turned, one of each other kind added, and one taken away.
    turn = math3d.rotation_euler((20.0, 30.0, 0.0))
    viewer.lights[:] = moved_lights(viewer.original, viewer.lights, 0, turn)
    viewer.add_light(viewer.lights[0].moved(math3d.rotation_euler((0.0, 0.0, 40.0))))
    for kind in KINDS.values():
        viewer.add_light(new_light(kind, viewer.camera, 0.4 * viewer.diagonal))
    viewer.remove_light(len(viewer.loaded.lights) - 1)
    viewer.apply_lights()
    viewer.settings = dataclasses.replace(viewer.settings, exposure=0.5, samples=16)
    for _ in range(10):
        viewer.frame(Controls(move=(0.3, 0.1, 1.0), turn_rate=(0.4, -0.1)), FRAME_S, SIZE)
    settle(viewer)


def rendered(device, arguments: list[str], out: Path) -> np.ndarray:
    assert main([*arguments, "--snapshot", str(out)]) == 0
    device.activate()
    with Image.open(out) as image:
        return np.asarray(image)[:, :, :3].astype(int)


def test_a_saved_scene_renders_the_same_picture(gl, device, viewer, tmp_path) -> None:
    settle(viewer)
    before = viewer.presenter.pixels().astype(int)
    edit(viewer)
    picture = viewer.presenter.pixels().astype(int)
    assert np.abs(picture - before).mean() > 5.0
    ask(viewer, Command.SAVE_SCENE)
    path = next(tmp_path.glob("*-001.toml"))
    assert path.name in said(viewer)
    again = rendered(device, [str(path)], tmp_path / "again.png")
    assert np.abs(again - picture).max() <= ROUNDING


def test_command_and_data_of_a_picture_keep_the_edits(gl, device, viewer, tmp_path) -> None:
    edit(viewer)
    picture = viewer.presenter.pixels().astype(int)
    command = shlex.split(ask(viewer, Command.COPY_COMMAND).clipboard)
    ask(viewer, Command.SCREENSHOT)
    data = json.loads(next(tmp_path.glob("*-001.json")).read_text())
    for words in (command, shlex.split(data["command"])):
        assert words[0] == "ssdo-gl"
        assert words[1].endswith(".toml")
        out = words.index("--snapshot")
        again = rendered(device, words[1:out] + words[out + 2 :], tmp_path / "again.png")
        assert np.abs(again - picture).max() <= ROUNDING


def test_a_key_chooses_the_material_under_the_cursor(gl, viewer) -> None:
    settle(viewer)
    ask(viewer, Command.MATERIAL)
    assert viewer.material is not None
    name = viewer.loaded.materials[viewer.material].name
    assert f"material: {name}" in said(viewer)


def test_undo_redo_and_reset_bring_pictures_back(gl, viewer) -> None:
    def shown() -> np.ndarray:
        settle(viewer)
        viewer.note_edits()
        return viewer.presenter.pixels()

    pictures = [shown()]
    viewer.lights[0] = viewer.lights[0].with_emitted((2.0, 1.0, 0.5))
    viewer.apply_lights()
    pictures.append(shown())
    viewer.original = dataclasses.replace(viewer.original, environment=SKY)
    viewer.apply_lights()
    pictures.append(shown())
    paint(viewer)
    viewer.apply_lights()
    pictures.append(shown())
    viewer.add_light(new_light(KINDS["point"], viewer.camera, 0.4 * viewer.diagonal))
    viewer.apply_lights()
    pictures.append(shown())
    viewer.remove_light(0)
    viewer.apply_lights()
    pictures.append(shown())
    viewer.settings = dataclasses.replace(viewer.settings, exposure=2.0)
    pictures.append(shown())
    for _ in range(5):
        viewer.frame(Controls(move=(0.0, 0.2, 1.0)), FRAME_S, SIZE)
    pictures.append(shown())
    for before in reversed(pictures[:-1]):
        ask(viewer, Command.UNDO)
        assert np.array_equal(shown(), before)
    ask(viewer, Command.UNDO)
    assert "nothing to undo" in said(viewer)
    assert not viewer.is_edited
    for after in pictures[1:]:
        ask(viewer, Command.REDO)
        # A camera that was gone to differs in its last digits.
        assert np.abs(shown().astype(int) - after).max() <= ROUNDING
    ask(viewer, Command.RESET)
    assert np.array_equal(shown(), pictures[0])
    ask(viewer, Command.UNDO)
    assert np.abs(shown().astype(int) - pictures[-1]).max() <= ROUNDING


def test_a_scene_in_a_folder_that_cannot_be_written_is_a_message(gl, viewer, tmp_path) -> None:
    edit(viewer)
    viewer.folder = tmp_path / "nowhere"
    viewer.source = str(tmp_path / "nowhere" / "gone.obj")
    ask(viewer, Command.SAVE_SCENE)
    (line,) = (line.text for line in viewer.messages.lines if line.is_fault)
    assert "nowhere" in line and line.endswith("open a copy in a folder of your own to save it")


@pytest.mark.parametrize("viewer", ["cornell_meso"], indirect=True)
def test_a_scene_of_a_model_behind_a_link_lies_beside_the_model(viewer, tmp_path) -> None:
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "model.obj").write_text(TRIANGLES)
    (tmp_path / "link.obj").symlink_to(tmp_path / "models" / "model.obj")
    assert open_file(str(tmp_path / "link.obj"), viewer)
    ask(viewer, Command.SAVE_SCENE)
    saved = load_scene(str(tmp_path / "models" / "model-001.toml"))
    assert saved.triangle_count == viewer.loaded.triangle_count


LEANING = "v -1 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 1\nv 0 -1 2\nf 1 2 3\nf 1 2 4\nf 1 4 5\n"
ASKED = [
    {"up": "z"},
    {"light": "studio"},
    {"light": "sky:9"},
    {"light": "map.hdr"},
    {"normals": "smooth", "crease_angle": 120.0},
    {"no_default_light": True},
    {"ground": "off"},
]


def model_folder(folder: Path) -> str:
    """Write a model and a map beside it; return the model's path."""
    (folder / "model.obj").write_text(LEANING)
    header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n"
    (folder / "map.hdr").write_bytes(header + bytes((90, 128, 60, 129)) * 8)
    return str(folder / "model.obj")


@pytest.mark.parametrize("asked", ASKED, ids=str)
def test_a_saved_scene_says_how_its_model_is_read(
    gl, device, make_viewer, tmp_path, monkeypatch, asked
) -> None:
    source = model_folder(tmp_path)
    monkeypatch.chdir(tmp_path)
    viewer = make_viewer(source, **{"ground": "auto", **asked})
    settle(viewer)
    picture = viewer.presenter.pixels().astype(int)
    ask(viewer, Command.SAVE_SCENE)
    path = str(next(tmp_path.glob("*-001.toml")))
    again = rendered(device, [path], tmp_path / "again.png")
    assert np.abs(again - picture).max() <= ROUNDING
    # Read again by the window, too, and as the command of an edited scene.
    paint(viewer)
    viewer.apply_lights()
    settle(viewer)
    picture = viewer.presenter.pixels().astype(int)
    words = shlex.split(ask(viewer, Command.COPY_COMMAND).clipboard)
    again = rendered(
        device, words[1 : words.index("--snapshot")] + words[4:], tmp_path / "again.png"
    )
    assert np.abs(again - picture).max() <= ROUNDING


def test_a_map_from_another_folder_is_named_where_a_scene_is_saved(gl, make_viewer, tmp_path):
    (tmp_path / "models").mkdir()
    source = model_folder(tmp_path / "models")
    image = (tmp_path / "models" / "map.hdr").rename(tmp_path / "map.hdr")
    viewer = make_viewer(source, light=str(image))
    ask(viewer, Command.SAVE_SCENE)
    assert f"--light {image}" in said(viewer)
    assert "map.hdr" not in (tmp_path / "models" / "model-001.toml").read_text()
