"""Pictures that the command writes, and what it says of them."""

from __future__ import annotations

import json

import numpy as np
import pytest
from command_scenes import SKY, SMALL, scene_file
from PIL import Image

from ssdo_gl.cli import main


def test_a_picture_is_written_and_described(tmp_path, capsys):
    out = tmp_path / "a.png"
    assert main([scene_file(tmp_path), "--snapshot", str(out), *SMALL]) == 0
    with Image.open(out) as image:
        assert image.size == (32, 18)
        assert np.asarray(image).std() > 1.0, "the picture is empty"
    said = capsys.readouterr().out
    for expected in ("32x18", "gi", "ms a frame", "passes: gbuffer", "OpenGL"):
        assert expected in said


def test_the_only_frame_is_not_said_to_be_usual(tmp_path, capsys):
    """All that is made once is in its time."""
    out = ["--snapshot", str(tmp_path / "a.npz"), "--method", "ssdo", *SMALL]
    assert main([scene_file(tmp_path), *out]) == 0
    said = capsys.readouterr().out
    assert ", first frame: " in said and "ms a frame" not in said
    assert main([scene_file(tmp_path), *out, "--frames", "2"]) == 0
    assert "ms a frame (first: " in capsys.readouterr().out


def test_passes_of_all_frames_of_a_picture_are_named(tmp_path, capsys):
    """What the first of its frames has made, the others keep."""
    said = []
    for count in ("1", "4"):
        flags = ["--antialias", count, *SMALL]
        assert main([scene_file(tmp_path), "--snapshot", str(tmp_path / "a.png"), *flags]) == 0
        lines = capsys.readouterr().out.splitlines()
        said.append([line for line in lines if line.startswith("passes: ")])
    assert "shadow_map" in said[0][0]
    assert said[0] == said[1]


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
