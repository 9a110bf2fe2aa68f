"""The command as a user meets it: flags, modes, and one line for each mistake."""

from __future__ import annotations

import json
import re
import subprocess
import sys

import moderngl
import numpy as np
import pytest
from command_scenes import BOX, SKY, SMALL, scene_file

from ssdo_gl.cli import main
from ssdo_gl.effects.registry import image_names, pass_settings
from ssdo_gl.gpu import texture_pool
from ssdo_gl.options.pass_settings import passes_without_settings
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.methods import METHODS


def refused(capsys, arguments):
    """Run a command that must fail on the user's input; return its one line."""
    assert main(arguments) == 2
    captured = capsys.readouterr()
    lines = captured.err.strip().splitlines()
    assert len(lines) == 1, captured.err
    assert "Traceback" not in captured.err
    return lines[0]


def test_a_size_that_opengl_has_no_images_of_is_refused(tmp_path, capsys, monkeypatch):
    def without_memory(*_rest):
        raise moderngl.Error("the framebuffer is not complete (INCOMPLETE_ATTACHMENT)")

    monkeypatch.setattr(texture_pool, "make_framebuffer", without_memory)
    out = str(tmp_path / "a.png")
    line = refused(capsys, [scene_file(tmp_path, SKY), "--snapshot", out, *SMALL])
    assert re.fullmatch(r"ssdo-gl: --size = 32x18: .+ makes no images so large", line)


def test_a_name_is_repeated_with_all_its_blanks(tmp_path, capsys):
    line = refused(capsys, [str(tmp_path / "my  room.toml"), "--explain"])
    assert line == f"ssdo-gl: {tmp_path}/my  room.toml: no such file"


def test_too_little_memory_is_one_line(tmp_path, capsys, monkeypatch):
    def without_memory(*_rest, **_options):
        raise MemoryError("Unable to allocate 128. MiB for an array")

    monkeypatch.setattr("ssdo_gl.renderer.Renderer.render", without_memory)
    line = refused(capsys, [scene_file(tmp_path), "--snapshot", str(tmp_path / "a.png"), *SMALL])
    assert line == "ssdo-gl: not enough memory: Unable to allocate 128. MiB for an array"


def test_explain_needs_no_output(capsys):
    assert main(["corner", "--method", "bounce", "--explain", *SMALL]) == 0
    said = capsys.readouterr().out
    assert "gbuffer" in said
    assert "neither an environment nor an ssdo light" in said


@pytest.mark.parametrize("module", ["ssdo_gl", "ssdo_gl.cli"])
def test_the_command_can_be_run_as_a_module(module):
    command = [sys.executable, "-m", module, "--version"]
    assert subprocess.run(command, capture_output=True, check=True).stdout.startswith(b"ssdo-gl ")


def test_version(capsys):
    with pytest.raises(SystemExit) as stop:
        main(["--version"])
    assert stop.value.code == 0
    assert capsys.readouterr().out.startswith("ssdo-gl ")


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        (["--size", "5"], "WIDTHxHEIGHT"),
        (["--estimator", "zbuffer"], "estimator"),
        (["--aov", "beauty,alb"], "--aov 'alb'"),
        (["--camera", "1,2"], "--camera"),
    ],
)
def test_bad_flags(tmp_path, capsys, flags, said):
    out = tmp_path / "kept.png"
    out.write_bytes(b"old")
    line = refused(capsys, [scene_file(tmp_path), "--snapshot", str(out), *flags])
    assert said in line
    assert out.read_bytes() == b"old"


# Whatever is wrong with flags and files is tested where they are read.
@pytest.mark.parametrize(
    ("name", "data", "word"),
    [
        ("no.toml", None, "no such file"),
        ("cut.glb", b"glTF\x02\0\0\0", "truncated GLB"),
        ("key.toml", f"{BOX}colour = 'red'\n".encode(), "colour"),
    ],
)
def test_bad_scenes(tmp_path, capsys, name, data, word):
    out = tmp_path / "kept.png"
    out.write_bytes(b"old")
    if data is not None:
        (tmp_path / name).write_bytes(data)
    line = refused(capsys, [str(tmp_path / name), "--snapshot", str(out), *SMALL])
    assert name in line and word in line
    assert out.read_bytes() == b"old"


@pytest.mark.parametrize(
    ("name", "said"), [("a.tif", "suffix"), ("no/a.png", "does not exist"), ("dir.png", "folder")]
)
def test_bad_outputs(tmp_path, capsys, name, said):
    (tmp_path / "dir.png").mkdir()
    line = refused(capsys, [scene_file(tmp_path), "--snapshot", str(tmp_path / name)])
    assert said in line


def test_every_picture_is_checked_before_anything_is_drawn(tmp_path, capsys):
    (tmp_path / "a-depth.png").mkdir()
    out = str(tmp_path / "a.png")
    assert main(["corner", "--snapshot", out, "--aov", "beauty,depth", *SMALL]) == 2
    assert "a-depth.png: is a folder" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["a-depth.png"]


@pytest.mark.parametrize("flag", ["--snapshot", "--bench"])
def test_an_empty_name_is_not_the_folder_one_is_in(tmp_path, capsys, monkeypatch, flag):
    monkeypatch.chdir(tmp_path)
    assert f"{flag} '': the name is empty" in refused(capsys, ["corner", flag, ""])
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("mode", [["--film"], ["--bench"], ["--batch", "--out"]])
def test_only_a_picture_goes_to_standard_output(tmp_path, capsys, monkeypatch, mode):
    monkeypatch.chdir(tmp_path)
    said = refused(capsys, ["corner", *mode, "-"])
    assert said == f"ssdo-gl: {mode[-1]} -: standard output takes the PNG of --snapshot alone"
    assert not list(tmp_path.iterdir())


def test_no_usable_opengl_is_exit_3(tmp_path, capsys, monkeypatch):
    from ssdo_gl.gpu import context

    def fail(_backend="auto"):
        raise context.ContextError("no OpenGL: install libegl1")

    monkeypatch.setattr("ssdo_gl.frame_loop.create_context", fail)
    assert main([scene_file(tmp_path), "--snapshot", str(tmp_path / "a.png"), *SMALL]) == 3
    assert "install" in capsys.readouterr().err


def test_ctrl_c_leaves_no_file(tmp_path, capsys, monkeypatch):
    def interrupt(*_args, **_kwargs):
        raise KeyboardInterrupt

    monkeypatch.setattr("ssdo_gl.renderer.Renderer.render", interrupt)
    out = tmp_path / "a.png"
    assert main([scene_file(tmp_path), "--snapshot", str(out), *SMALL]) == 130
    assert "interrupted" in capsys.readouterr().err
    assert not out.exists()


def test_explanations_say_what_was_saved(tmp_path, capsys):
    stats = tmp_path / "stats.json"
    words = ["corner", "--method", "bounce", "--explain", "--stats", str(stats)]
    assert main([*words, *SMALL]) == 0
    text = capsys.readouterr().out
    assert "passes ran;" in text and "saved" in text and "whole frame" in text
    decisions = {row["effect"]: row for row in json.loads(stats.read_text())["decisions"]}
    skipped = decisions["directional occlusion"]
    # Other programs may take a round; what most rounds found stands in the range.
    assert not skipped["run"] and skipped["saved_ms_range"][1] > 0.0
    assert skipped["reason"] == "there is neither an environment nor an ssdo light that is on"


def test_a_scene_may_set_size_and_antialiasing_of_a_picture(tmp_path):
    text = BOX + "[render]\nsize = [20, 10]\nantialias = 2\nsamples = 8\n"
    stats = tmp_path / "s.json"
    command = [scene_file(tmp_path, text), "--stats", str(stats)]
    assert main([*command, "--snapshot", str(tmp_path / "a.png")]) == 0
    settings = json.loads(stats.read_text())["settings"]
    assert (settings["size"], settings["antialias"], settings["samples"]) == ([20, 10], 2, 8)
    assert main([*command, "--snapshot", str(tmp_path / "a.png"), "--antialias", "1"]) == 0
    assert json.loads(stats.read_text())["settings"]["antialias"] == 1


def test_an_estimator_may_be_that_of_the_method_the_scene_sets(tmp_path):
    text = BOX + "[render]\nmethod = 'ssao'\n"
    command = [scene_file(tmp_path, text), "--estimator", "hemisphere", *SMALL]
    assert main([*command, "--snapshot", str(tmp_path / "a.png"), "--quiet"]) == 0


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        (["--frames", "3"], "--frames has no effect in the window"),
        (["--stats", "s.json"], "--stats has no effect in the window"),
        (["--backend", "egl"], "--backend egl makes no window"),
        (["--aov", "all"], "a window begins with one of"),
    ],
)
def test_flags_without_effect_in_a_window_are_refused(capsys, flags, said):
    assert said in refused(capsys, ["corner", *flags])


def test_the_window_begins_with_the_image_and_the_time_that_are_named(monkeypatch):
    taken = {}
    monkeypatch.setattr(
        "ssdo_gl.window.window.open_window", lambda *args, **more: taken.update(more)
    )
    assert main(["corner", "--aov", "depth", "--time", "2.5", "--backend", "window"]) == 0
    assert (taken["aov"], taken["seconds"]) == ("depth", 2.5)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("scene", ["courtyard", "furnace"])
def test_set_knows_every_pass_that_is_explained(scene, method):
    """By the name that `--explain` gives it; a pass without settings says so."""
    known = {*pass_settings(), *passes_without_settings()}
    settings = Settings(size=(16, 9), method=method, spp=1, samples=8)
    with Renderer(load_scene(scene), settings) as renderer:
        passes = {row.name for row in renderer.render(image_names()).passes}
    assert "gbuffer" in passes
    assert passes <= known, passes - known


@pytest.mark.parametrize(
    ("scene", "method", "aov", "changed"),
    [
        ("courtyard", "ssao", "visibility", "ssao_filter"),
        ("courtyard", "bounce", "directional", "directional_filter"),
        ("courtyard", "bounce", "bounce", "bounce_filter"),
        # One colour from everywhere: visibility is all that directions would tell.
        ("sky.toml", "ssdo", "directional", "directional_filter"),
    ],
)
def test_set_reaches_filters_one_by_one(tmp_path, scene, method, aov, changed):
    images = {}
    scene = scene_file(tmp_path, SKY) if scene == "sky.toml" else scene
    for name in ("ssao_filter", "directional_filter", "bounce_filter", None):
        out = tmp_path / f"{name}.npz"
        command = [scene, "--method", method, "--aov", aov, "--snapshot", str(out)]
        flags = [] if name is None else ["--set", f"{name}.filter=none"]
        if main([*command, *SMALL, "--quiet", *flags]) == 2:
            continue  # A filter that the method lacks.
        with np.load(out) as file:
            images[name] = file[aov]
    different = {name for name in images if not np.array_equal(images[name], images[None])}
    # What surfaces send on has been filtered, too.
    assert different - {"directional_filter"} == {changed} - {"directional_filter"}
    assert changed in different
