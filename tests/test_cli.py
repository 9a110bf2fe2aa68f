"""The command as a user meets it: files, exit codes, one line for each mistake."""

from __future__ import annotations

import dataclasses
import json
import re
import struct
import zlib

import moderngl
import numpy as np
import pytest
import trimesh
from PIL import Image

from ssdo_gl.cli import main
from ssdo_gl.effects.methods import METHODS
from ssdo_gl.effects.registry import image_names, pass_settings
from ssdo_gl.gpu import texture_pool
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.environment.environment_kinds import MapEnvironment
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.passes import passes_without_settings

TINY = ["--size", "32x18"]
SMALL = [*TINY, "--samples", "8"]
BOX = """
[[object]]
shape = "box"
min = [0, 0, 0]
max = [1, 1, 1]
"""
# A box on a floor, under a sky of one colour.
SKY = f"""
[camera]
position = [1.5, 2.2, 3]
target = [0.5, 0.1, 1.2]
[environment]
kind = "constant"
radiance = [1, 1, 1]
[[object]]
shape = "box"
min = [-9, 0, -9]
max = [9, 0.1, 9]
{BOX}
"""


def scene_file(folder, text=BOX, name="scene.toml"):
    path = folder / name
    path.write_text(text)
    return str(path)


def refused(capsys, arguments):
    """Run a command that must fail on the user's input; return its one line."""
    assert main(arguments) == 2
    captured = capsys.readouterr()
    lines = captured.err.strip().splitlines()
    assert len(lines) == 1, captured.err
    assert "Traceback" not in captured.err
    return lines[0]


# --- what works --------------------------------------------------------------------


def test_a_picture_is_written_and_described(tmp_path, capsys):
    out = tmp_path / "a.png"
    assert main([scene_file(tmp_path), "--snapshot", str(out), *SMALL]) == 0
    with Image.open(out) as image:
        assert image.size == (32, 18)
        assert np.asarray(image).std() > 1.0, "the picture is empty"
    said = capsys.readouterr().out
    for expected in ("32x18", "gi", "ms a frame", "passes: gbuffer", "OpenGL"):
        assert expected in said


def test_a_size_that_opengl_has_no_images_of_is_refused(tmp_path, capsys, monkeypatch):
    def without_memory(*_rest):
        raise moderngl.Error("the framebuffer is not complete (INCOMPLETE_ATTACHMENT)")

    monkeypatch.setattr(texture_pool, "make_framebuffer", without_memory)
    out = str(tmp_path / "a.png")
    line = refused(capsys, [scene_file(tmp_path, SKY), "--snapshot", out, *SMALL])
    assert re.fullmatch(r"ssdo-gl: --size = 32x18: .+ makes no images so large", line)


def test_quiet_says_nothing(tmp_path, capsys):
    assert (
        main([scene_file(tmp_path), "--snapshot", str(tmp_path / "a.png"), "--quiet", *SMALL]) == 0
    )
    assert capsys.readouterr() == ("", "")


def test_every_aov_in_one_array_file(tmp_path):
    out = tmp_path / "a.npz"
    assert main([scene_file(tmp_path), "--snapshot", str(out), "--aov", "all", *SMALL]) == 0
    with np.load(out) as file:
        channels = {name: file[name].shape[2] for name in file.files if name != "meta"}
        assert json.loads(str(file["meta"]))["size"] == [32, 18]
        assert all(np.isfinite(file[name]).all() for name in channels)
        assert file["depth"].max() > 0.0
    assert channels == {
        "beauty": 4,
        "emission": 3,
        "direct": 3,
        "specular": 3,
        "directional": 3,
        "bounce": 3,
        "visibility": 1,
        "albedo": 3,
        "normal_ws": 3,
        "position_ws": 3,
        "depth": 1,
    }


def test_the_beauty_is_the_sum_of_its_terms(tmp_path):
    out = tmp_path / "a.npz"
    assert main(["cornell_meso", "--snapshot", str(out), "--aov", "all", *SMALL]) == 0
    with np.load(out) as file:
        terms = file["emission"] + file["direct"] + file["directional"] + file["bounce"]
        covered = file["depth"][:, :, 0] > 0.0
        # Four float32 additions of terms of the same sign.
        np.testing.assert_allclose(file["beauty"][covered][:, :3], terms[covered], rtol=1e-6)


def test_the_same_command_gives_the_same_bytes(tmp_path):
    first, second = tmp_path / "1.npz", tmp_path / "2.npz"
    for out in (first, second):
        assert main(["cornell_meso", "--snapshot", str(out), "--aov", "all", *SMALL]) == 0
    assert first.read_bytes() == second.read_bytes()


def test_another_seed_gives_another_noise(tmp_path):
    images = []
    for seed in ("0", "1"):
        out = tmp_path / f"{seed}.npz"
        main(
            ["cornell_meso", "--snapshot", str(out), "--aov", "visibility", "--seed", seed, *SMALL]
        )
        with np.load(out) as file:
            images.append(file["visibility"])
    assert not np.array_equal(*images)


def test_several_pictures_get_names(tmp_path):
    out = tmp_path / "a.png"
    command = [scene_file(tmp_path), "--snapshot", str(out), "--aov", "beauty,depth", *SMALL]
    assert main(command) == 0
    assert {path.name for path in tmp_path.glob("*.png")} == {"a.png", "a-depth.png"}


@pytest.mark.parametrize("suffix", [".jpg", ".JPEG", ".webp"])
def test_a_lossy_picture_is_close_to_the_png(tmp_path, suffix):
    command = ["cornell_meso", *SMALL, "--quiet", "--snapshot"]
    for name in ("a.png", f"a{suffix}"):
        assert main([*command, str(tmp_path / name)]) == 0
    with Image.open(tmp_path / "a.png") as exact, Image.open(tmp_path / f"a{suffix}") as lossy:
        assert lossy.format == ("WEBP" if suffix == ".webp" else "JPEG")
        assert lossy.mode == "RGB"
        gap = np.asarray(lossy.convert("L"), int) - np.asarray(exact.convert("L"), int)
    assert np.sqrt(np.mean(gap**2)) < 3.0


@pytest.mark.parametrize(("suffix", "corner"), [(".jpg", (255, 255, 255)), (".webp", (0,))])
def test_what_is_transparent_is_white_where_a_file_has_no_alpha(tmp_path, suffix, corner):
    out = tmp_path / f"a{suffix}"
    command = [scene_file(tmp_path, SKY), "--background", "transparent", "--quiet", *SMALL]
    camera = ["--camera", "0,40,0.1 0,0,0"]
    assert main([*command, *camera, "--snapshot", str(out)]) == 0
    with Image.open(out) as image:
        pixel = image.getpixel((0, 0))
    assert pixel[-len(corner) :] == pytest.approx(corner, abs=1)


def test_statistics_have_the_promised_form(tmp_path):
    stats = tmp_path / "s.json"
    command = ["cornell_meso", "--snapshot", str(tmp_path / "a.npz"), "--stats", str(stats)]
    assert main([*command, "--frames", "3", *SMALL]) == 0
    content = json.loads(stats.read_text())
    for key in ("renderer", "gl_version", "backend", "timer", "settings"):
        assert content[key]
    assert content["size"] == [32, 18]
    assert content["frames"] == 3
    assert set(content["frame_ms"]) == {"median", "min", "max"}
    by_name = {row["name"]: row for row in content["passes"]}
    assert set(by_name["gbuffer"]) == {"name", "ran", "reason", "gpu_ms", "cpu_ms"}
    assert by_name["gbuffer"]["ran"] and by_name["gbuffer"]["gpu_ms"] > 0.0
    assert all(row["reason"] for row in content["passes"])


def test_explain_needs_no_output(capsys):
    assert main(["corner", "--method", "bounce", "--explain", *SMALL]) == 0
    said = capsys.readouterr().out
    assert "gbuffer" in said
    assert "neither an environment nor an ssdo light" in said


@pytest.mark.parametrize(("more", "rays"), [([], 4), (["--spp", "6"], 6), (["--snapshot"], 256)])
def test_a_reference_that_is_only_explained_takes_few_rays(tmp_path, capsys, more, rays):
    out = [str(tmp_path / "a.npz")] if more == ["--snapshot"] else []
    assert main(["corner", "--method", "reference-ao", "--explain", *more, *out, *TINY]) == 0
    assert f"{rays} samples per pixel" in capsys.readouterr().out


def test_version(capsys):
    with pytest.raises(SystemExit) as stop:
        main(["--version"])
    assert stop.value.code == 0
    assert capsys.readouterr().out.startswith("ssdo-gl ")


# --- what is refused ---------------------------------------------------------------


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        (["--size", "0x5"], "--size"),
        (["--size", "5"], "WIDTHxHEIGHT"),
        (["--time", "nan"], "--time = nan"),
        (["--radius", "-1"], "--radius = -1.0: expected a number from 1e-15"),
        (["--radius", "wide"], "--radius"),
        (["--samples", "0"], "--samples = 0"),
        (["--method", "magic"], "--method"),
        (["--estimator", "zbuffer"], "estimator"),
        (["--aov", "beauty,alb"], "--aov 'alb'"),
        (["--camera", "1,2"], "--camera"),
        (["--set", "bounce.strenght=2"], "did you mean 'strength'"),
        (["--frames", "0"], "--frames = 0"),
        (["--sise", "3x3"], "--sise"),
        (["--resolution-scale", "0.7"], "--resolution-scale"),
    ],
)
def test_bad_flags(tmp_path, capsys, flags, said):
    out = tmp_path / "kept.png"
    out.write_bytes(b"old")
    line = refused(capsys, [scene_file(tmp_path), "--snapshot", str(out), *flags])
    assert said in line
    assert out.read_bytes() == b"old"


def truncated_glb(path):
    trimesh.creation.box().export(path)
    path.write_bytes(path.read_bytes()[:200])


def huge_png(path):
    """A PNG whose header promises 30000 x 30000 pixels, with next to nothing behind it."""

    def chunk(kind, body):
        crc = struct.pack(">I", zlib.crc32(kind + body))
        return struct.pack(">I", len(body)) + kind + body + crc

    header = chunk(b"IHDR", struct.pack(">IIBBBBB", 30000, 30000, 8, 2, 0, 0, 0))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", zlib.compress(b"0")))


def bad_scenes(folder):
    """Return {what is wrong: (scene argument, word the message must have)}."""
    truncated_glb(folder / "cut.glb")
    huge_png(folder / "huge.png")
    (folder / "nan.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "nan nan nan\nnan nan nan\nnan nan nan\n3 0 1 2\n"
    )
    (folder / "empty.obj").write_text("# nothing\n")
    (folder / "flat.obj").write_text("v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n")
    (folder / "scene.txt").write_text("hello")
    (folder / "secret.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    inner = folder / "inner"
    inner.mkdir()
    write = lambda name, text: scene_file(folder, text, name)  # noqa: E731
    return {
        "missing file": (str(folder / "no.toml"), "no.toml"),
        "missing model": (str(folder / "no.glb"), "no.glb"),
        "wrong suffix": (str(folder / "scene.txt"), ".glb"),
        "unknown name": ("cornel_meso", "cornell_meso"),
        "truncated glb": (str(folder / "cut.glb"), "cut.glb"),
        "nan mesh": (str(folder / "nan.ply"), "nan.ply"),
        "empty mesh": (str(folder / "empty.obj"), "empty.obj"),
        "zero-area triangles only": (str(folder / "flat.obj"), "flat.obj"),
        "toml syntax": (write("syntax.toml", "[[object]\nshape = 1"), "line 1"),
        "unknown key": (write("key.toml", BOX + "colour = 'red'\n"), "colour"),
        "negative size": (
            write("negative.toml", '[[object]]\nshape = "sphere"\ncenter = [0,0,0]\nradius = -1\n'),
            "radius",
        ),
        "inverted box": (
            write("inverted.toml", '[[object]]\nshape = "box"\nmin = [1,0,0]\nmax = [0,1,1]\n'),
            "max",
        ),
        "escape": (
            scene_file(inner, '[[object]]\nshape = "mesh"\npath = "../secret.obj"\n'),
            "../secret.obj",
        ),
        "huge texture": (
            write(
                "huge.toml",
                '[materials.m]\nalbedo_texture = "huge.png"\n' + BOX + 'material = "m"\n',
            ),
            "30000",
        ),
        "no geometry": (write("none.toml", 'title = "empty"\n'), "object"),
        "nan number": (write("nan.toml", BOX.replace("[1, 1, 1]", "[nan, 1, 1]")), "nan"),
    }


BAD_SCENES = [
    "missing file",
    "missing model",
    "wrong suffix",
    "unknown name",
    "truncated glb",
    "nan mesh",
    "empty mesh",
    "zero-area triangles only",
    "toml syntax",
    "unknown key",
    "negative size",
    "inverted box",
    "escape",
    "huge texture",
    "no geometry",
    "nan number",
]


@pytest.mark.parametrize("what", BAD_SCENES)
def test_bad_scenes(tmp_path, capsys, what):
    scenes = bad_scenes(tmp_path)
    assert set(scenes) == set(BAD_SCENES)
    source, word = scenes[what]
    out = tmp_path / "kept.png"
    out.write_bytes(b"old")
    line = refused(capsys, [source, "--snapshot", str(out), *SMALL])
    assert word in line
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


def test_ctrl_c_keeps_what_a_reference_has_reached(tmp_path, capsys, monkeypatch):
    """The second draw is interrupted; the first one's samples are in the file."""
    draws = []
    from ssdo_gl.passes.rays import accumulate

    draw = accumulate.draw_fullscreen

    def interrupted(*args, **kwargs):
        draws.append(1)
        if len(draws) == 3:
            raise KeyboardInterrupt
        draw(*args, **kwargs)

    monkeypatch.setattr(accumulate, "draw_fullscreen", interrupted)
    out = tmp_path / "a.npz"
    command = ["corner", "--method", "reference-ao", "--aov", "visibility", "--spp", "4096"]
    assert main([*command, "--snapshot", str(out), "--antialias", "4", *TINY]) == 130
    captured = capsys.readouterr()
    assert "interrupted" in captured.err
    assert "partial" in captured.out
    with np.load(out) as file:
        meta = json.loads(str(file["meta"]))
        assert 0.0 < file["visibility"].mean() <= 1.0
    assert meta["partial"] is True
    assert meta["references"]["reference_ao"]["spp"] < 4096


REFERENCE_AO = ("corner", "--method", "reference-ao", "--aov", "visibility", "--spp", "4")


def test_ctrl_c_before_a_reference_s_first_sample_leaves_no_file(tmp_path, capsys, monkeypatch):
    """It was a black picture that held "what the reference had reached"."""

    def interrupted(*_args, **_kwargs):
        raise KeyboardInterrupt

    monkeypatch.setattr("ssdo_gl.passes.rays.accumulate.draw_fullscreen", interrupted)
    out = tmp_path / "a.npz"
    assert main([*REFERENCE_AO, "--snapshot", str(out), *TINY]) == 130
    assert capsys.readouterr().err == "ssdo-gl: interrupted; nothing was written\n"
    assert not list(tmp_path.iterdir())


def test_a_frame_without_a_sample_does_not_darken_those_before_it(tmp_path, capsys, monkeypatch):
    from ssdo_gl.passes.rays import accumulate

    draw, draws = accumulate.draw_fullscreen, []

    def counted(*args, **kwargs):
        draws.append(1)
        if len(draws) > stops_after:
            raise KeyboardInterrupt
        draw(*args, **kwargs)

    monkeypatch.setattr(accumulate, "draw_fullscreen", counted)
    stops_after = 1_000_000
    out = tmp_path / "a.npz"
    assert main([*REFERENCE_AO, "--snapshot", str(out), *TINY]) == 0
    stops_after = len(draws)
    draws.clear()
    one = np.load(out)["visibility"]
    words = [*REFERENCE_AO, "--snapshot", str(out), "--antialias", "2", *TINY]
    assert main(words) == 130
    assert "holds what the reference had reached" in capsys.readouterr().err
    with np.load(out) as file:
        assert file["visibility"].mean() == pytest.approx(one.mean(), rel=0.05)
        assert json.loads(str(file["meta"]))["partial"] is True


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


# --- references: what they reached, and whether that is enough -----------------------

REFERENCE = ["corner", "--method", "reference-ao", "--aov", "visibility"]


@pytest.mark.parametrize("spp", ["1", "2"])
def test_an_error_that_nobody_can_know_is_said_to_be_unknown(tmp_path, capsys, spp):
    out = str(tmp_path / "a.npz")
    assert main([*REFERENCE, "--spp", spp, "--snapshot", out, *TINY]) == 0
    said = capsys.readouterr().out
    assert ("visibility unknown" in said) == (spp == "1")


@pytest.mark.parametrize("method", ["reference-ao", "reference-near", "reference-gi"])
def test_a_view_without_surfaces_has_no_error(tmp_path, capsys, method):
    out = str(tmp_path / "a.npz")
    away = ["--camera", "0,0,100 0,0,200", "--spp", "4"]
    assert main(["corner", "--method", method, *away, "--snapshot", out, *TINY]) == 0
    assert "Traceback" not in capsys.readouterr().err


def test_a_reference_goes_on_until_its_bound_holds(tmp_path, capsys):
    """256 rays, the usual number, leave 1.5 % here: four times as many are needed."""
    stats = tmp_path / "s.json"
    command = [*REFERENCE, "--size", "32x18", "--stats", str(stats)]
    assert main([*command, "--explain", "--spp", "256"]) == 0
    first = json.loads(stats.read_text())["references"]["reference_ao"]
    bound = 0.5 * first["relative_standard_error"]["visibility"]
    capsys.readouterr()
    assert main([*command, "--explain", "--max-error", repr(bound)]) == 0
    content = json.loads(stats.read_text())["references"]["reference_ao"]
    assert first["spp"] == 256 < content["spp"]
    assert content["relative_standard_error"]["visibility"] <= bound
    assert content["stopped_by"] == "max_error"
    # A number that was asked for is the limit, and that it was met is said.
    assert main([*command, "--explain", "--max-error", repr(bound), "--spp", "256"]) == 4
    captured = capsys.readouterr()
    assert "after 256 samples per pixel, --max-error asked for" in captured.err
    assert len(captured.err.strip().splitlines()) == 1


# --- scene, flags and modes -----------------------------------------------------------


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


def test_set_reaches_the_environment():
    pixels = np.random.default_rng(1).uniform(0.0, 2.0, (8, 16, 3)).astype(np.float32)
    scene = dataclasses.replace(load_scene("courtyard"), environment=MapEnvironment(pixels))
    images = []
    for overrides in ({}, {"environment.irradiance_size": 4}):
        settings = Settings(size=(32, 18), method="ssao", samples=8, overrides=overrides)
        with Renderer(scene, settings) as renderer:
            images.append(renderer.render().images["beauty"])
    assert not np.array_equal(*images)
