"""Films without a window: the frames of snapshots, kept whole whatever happens."""

from __future__ import annotations

import dataclasses
import json
import signal
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import ssdo_gl
from ssdo_gl.cli import main
from ssdo_gl.farm.scheduler import FarmError
from ssdo_gl.film import writers
from ssdo_gl.film.camera_path import CameraPath
from ssdo_gl.film.shots import Shots
from ssdo_gl.headless import film
from ssdo_gl.headless.film import FilmRequest, check_film, make_film
from ssdo_gl.headless.film_frames import EncodedFrame
from ssdo_gl.headless.snapshot import SnapshotRequest, take_snapshot
from ssdo_gl.images.files import OutputError
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings

SIZE = (64, 36)
TURN = ["--turntable", "--frames-range", "0:4", "--size", "64x36", "--method", "direct", "--quiet"]


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize("name", ["x" * 300, "x" * 5000, "x" * 300 + ".mp4", "x" * 300 + "%d.png"])
def test_a_name_that_no_file_has_is_refused_in_one_line(name: str) -> None:
    with pytest.raises(OutputError, match="too long"):
        check_film(Path(name), ("beauty",))


@pytest.mark.parametrize("scene_name", ["stairs", "carousel"])
@pytest.mark.parametrize(
    ("suffix", "method"), [(".png", "bounce"), (".npz", "gi"), (".exr", "ssdo")]
)
def test_frames_are_those_of_snapshots(
    tmp_path: Path, scene_name: str, suffix: str, method: str
) -> None:
    scene = load_scene(scene_name)
    settings = Settings(method=method, size=SIZE, samples=16, antialias=2)
    wanted = ("beauty", "depth")
    shots = Shots(turntable=90.0, fps=2.0, start_s=0.25, frames=(0, 3, 3))
    pattern = tmp_path / "film" / f"turn%02d{suffix}"
    request = FilmRequest(scene, settings, pattern, shots, wanted, quiet=True)
    assert make_film(request).rendered_count == 3
    stills = tmp_path / "stills"
    stills.mkdir()
    for index in range(3):
        take_snapshot(
            SnapshotRequest(
                scene,
                settings,
                wanted,
                stills / f"turn{index:02d}{suffix}",
                scene.camera.orbit(30.0 * index),
                seconds=0.25 + index / 2.0,
                quiet=True,
            )
        )
    assert contents(tmp_path / "film") == contents(stills)
    assert len(contents(stills)) == (6 if suffix == ".png" else 3)


def test_a_film_follows_a_recorded_path(tmp_path: Path) -> None:
    scene = load_scene("corner")
    closer = dataclasses.replace(scene.camera, fov_y=20.0)
    path = CameraPath().recorded(0.0, scene.camera).recorded(1.0, closer)
    views = tmp_path / "corner.views.json"
    views.write_text(json.dumps({"path": path.to_data()}))
    words = ["corner", "--film", str(tmp_path / "walk"), "--path", str(views), "--fps", "3"]
    assert main([*words, *TURN[3:], "--aov", "normal_ws"]) == 0
    with Renderer(scene, Settings(size=SIZE)) as renderer:
        camera = path.camera(2 / 3, scene.camera)
        normal = renderer.render(["normal_ws"], camera=camera).images["normal_ws"]
    assert sorted(contents(tmp_path / "walk")) == [f"frame_{n:04d}.png" for n in range(3)]
    with Image.open(tmp_path / "walk" / "frame_0002.png") as image:
        shown = np.asarray(image)[..., :3] / 255.0
    seen = np.any(normal, axis=2)
    assert np.abs(shown - (0.5 * normal + 0.5))[seen].max() < 1 / 255


def test_resume_renders_the_missing_and_empty_frames_alone(tmp_path: Path) -> None:
    out = tmp_path / "turn"
    words = ["corner", "--film", str(out), *TURN]
    assert main(words) == 0
    whole = contents(out)
    (out / "frame_0001.png").unlink()
    (out / "frame_0002.png").write_bytes(b"")
    (out / "frame_0003.png").write_bytes(b"kept")
    assert main([*words, "--resume"]) == 0
    assert contents(out) == whole | {"frame_0003.png": b"kept"}
    assert main(words) == 0
    assert contents(out) == whole


def test_frames_above_the_error_bound_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["stairs", "--film", str(tmp_path / "turn"), "--turntable", "--frames-range", "1:3"]
    flags = ["--method", "reference-near", "--spp", "64", "--max-error", "1e-6", "--size", "32x18"]
    assert main([*words, *flags, "--quiet"]) == 4
    lines = capsys.readouterr().err.splitlines()
    assert {line.split(": ")[1] for line in lines} == {"frame 1", "frame 2"}
    assert len(contents(tmp_path / "turn")) == 2


def interrupted_at(monkeypatch: pytest.MonkeyPatch, count: int) -> None:
    """Let Ctrl-C be pressed while frame `count` is drawn."""
    drawn, render = [], Renderer.render

    def interrupt(*arguments: object, **options: object) -> object:
        drawn.append(1)
        if len(drawn) > count:
            signal.raise_signal(signal.SIGINT)
        return render(*arguments, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(Renderer, "render", interrupt)


def test_ctrl_c_leaves_whole_frames(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["corner", "--film", str(tmp_path / "turn"), *TURN]
    with monkeypatch.context() as patch:
        interrupted_at(patch, 2)
        assert main(words) == 130
    assert "interrupted; " in (said := capsys.readouterr().err) and "2 of the 4 frames" in said
    assert sorted(contents(tmp_path / "turn")) == ["frame_0000.png", "frame_0001.png"]
    assert main([*words, "--resume"]) == 0
    assert len(contents(tmp_path / "turn")) == 4


def test_ctrl_c_while_a_frame_is_written_waits_for_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write = film.write_atomically

    def late(*arguments: object) -> None:
        signal.raise_signal(signal.SIGINT)
        write(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(film, "write_atomically", late)
    assert main(["corner", "--film", str(tmp_path / "turn"), *TURN]) == 130
    assert sorted(contents(tmp_path / "turn")) == ["frame_0000.png"]


def test_an_encoder_that_is_killed_says_by_what(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    encoder = tmp_path / "encoder"
    encoder.write_text("#!/bin/sh\ncat > /dev/null\nkill -XFSZ $$\n")
    encoder.chmod(0o755)
    monkeypatch.setattr(ffmpeg, "get_ffmpeg_exe", lambda: str(encoder))
    assert main(["corner", "--film", str(tmp_path / "turn.mp4"), *TURN]) != 0
    why = signal.strsignal(signal.SIGXFSZ)
    assert f"turn.mp4: cannot be encoded: ended by {why}" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [encoder]


# imageio-ffmpeg leaves the pipes to its process to the garbage collector.
@pytest.mark.filterwarnings("ignore::ResourceWarning")
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("suffix", [".gif", ".webp", ".mp4", ".webm"])
def test_ctrl_c_leaves_a_film_that_plays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    out = tmp_path / f"turn{suffix}"
    interrupted_at(monkeypatch, 3)
    if suffix in (".mp4", ".webm"):
        ffmpeg = pytest.importorskip("imageio_ffmpeg")
        assert main(["corner", "--film", str(out), *TURN]) == 130
        reader = ffmpeg.read_frames(str(out))
        assert next(reader)["size"] == SIZE
        assert len(list(reader)) == 3
    else:
        assert main(["corner", "--film", str(out), *TURN]) == 130
        with Image.open(out) as image:
            assert (image.size, image.n_frames) == (SIZE, 3)  # type: ignore[attr-defined]
    assert list(tmp_path.iterdir()) == [out]


@pytest.mark.parametrize("suffix", [".gif", ".webp"])
def test_ctrl_c_while_a_film_is_encoded_does_not_say_that_there_is_none(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    suffix: str,
) -> None:
    out = tmp_path / f"turn{suffix}"
    write = writers.write_atomically

    def late(*arguments: object) -> None:
        signal.raise_signal(signal.SIGINT)
        write(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(writers, "write_atomically", late)
    assert main(["corner", "--film", str(out), *TURN]) == 130
    assert capsys.readouterr().err == f"ssdo-gl: interrupted; {out} has all of the 4 frames\n"
    with Image.open(out) as image:
        assert image.n_frames == 4  # type: ignore[attr-defined]


@pytest.mark.parametrize("out", ["turn", "turn.gif"])
def test_workers_that_are_lost_leave_the_frames_they_have_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], out: str
) -> None:
    def two(_: str, open_maker: Any, task: Any, indices: range) -> Iterator[EncodedFrame]:
        with closing(open_maker(task)) as maker:
            yield from (maker.make(index) for index in indices[:2])
        raise FarmError("no worker is left")

    words = ["corner", "--film", str(tmp_path / out), *TURN]
    with monkeypatch.context() as patch:
        patch.setattr(film, "mapped", two)
        assert main([*words, "--scheduler", "local:1"]) == 2
    said = f"ssdo-gl: no worker is left; {tmp_path / out} has 2 of the 4 frames\n"
    assert capsys.readouterr().err == said
    if out == "turn.gif":
        with Image.open(tmp_path / out) as image:
            assert image.n_frames == 2  # type: ignore[attr-defined]
        return
    assert sorted(contents(tmp_path / out)) == ["frame_0000.png", "frame_0001.png"]
    assert main([*words, "--resume"]) == 0
    assert len(contents(tmp_path / out)) == 4


@pytest.mark.parametrize("out", ["turn", "turn.gif"])
def test_ctrl_c_before_the_first_frame_leaves_no_film(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], out: str
) -> None:
    interrupted_at(monkeypatch, 0)
    assert main(["corner", "--film", str(tmp_path / out), *TURN]) == 130
    assert "nothing was written" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


# A quad that glows by 1000: it would be white.
GLOWING = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl lamp\nf 1 2 3 4\n"


def test_a_measured_exposure_is_that_of_frame_0_even_when_resumed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "lamp.mtl").write_text("newmtl lamp\nKd 0 0 0\nKe 1000 1000 1000\n")
    model = tmp_path / "lamp.obj"
    model.write_text(f"mtllib lamp.mtl\n{GLOWING}")
    words = [str(model), "--film", str(tmp_path / "turn"), *TURN[:-1]]
    assert main(words) == 0
    assert capsys.readouterr().err.count("note: exposure -11.5 EV, measured") == 1
    whole = contents(tmp_path / "turn")
    (tmp_path / "turn" / "frame_0002.png").unlink()
    assert main([*words, "--resume"]) == 0
    assert contents(tmp_path / "turn") == whole


@pytest.mark.parametrize(
    ("out", "flags", "said"),
    [
        (
            "a.avi",
            TURN,
            "a.avi: expected a film (.mp4, .webm, .webp, .gif), a folder, or a pattern",
        ),
        ("a.png", TURN, "a.png: expected a film"),
        ("%s.png", TURN, "%s.png: expected a film"),
        ("%d%d.png", TURN, "%d%d.png: expected a film"),
        ("%d.gif", TURN, "%d.gif: expected a film"),
        ("a.gif", [*TURN, "--resume"], "a.gif: --resume needs frames in files of their own"),
        ("a.gif", [*TURN, "--aov", "beauty,depth"], "a.gif: one image fits a film, not 2"),
        ("no/where/a", TURN, "does not exist"),
        ("no/a.gif", TURN, "does not exist"),
        ("a", TURN[3:], "--film: a film needs its length: --turntable, --path"),
        ("a", ["--frames-range", "9"], "--frames-range '9': expected A:B"),
        ("a", ["--path", "no.json"], "no.json: no such file"),
        ("a", ["--path", "no.json", *TURN], "--turntable has no effect with --path"),
        ("a", ["--path", "no.json", "--camera", "fit"], "--camera has no effect with --path"),
        ("", TURN, "--film '': the name is empty"),
    ],
)
def test_impossible_films_are_refused_in_one_line(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    out: str,
    flags: list[str],
    said: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["corner", "--film", out, *flags]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1 and said in lines[0]
    assert list(tmp_path.iterdir()) == []


def test_frames_from_python() -> None:
    frames = list(
        ssdo_gl.film_frames("corner", turntable=360, frames=(1, 3, 4), aov=["depth"], size=(32, 18))
    )
    assert [frame.index for frame in frames] == [1, 2]
    scene = load_scene("corner")
    assert frames[1].camera == scene.camera.orbit(180.0)
    with Renderer(scene, Settings(size=(32, 18))) as renderer:
        depth = renderer.render(["depth"], camera=frames[1].camera).images["depth"]
    assert np.array_equal(frames[1].images["depth"], depth)
    fit = ssdo_gl.film_frames("corner", turntable=360, frames=(0, 1), camera="fit", size=(8, 8))
    assert next(fit).camera == load_scene("corner", camera="fit").camera


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"frames": range(2)}, r"frames = range\(0, 2\): expected \(first, end\)"),
        ({"frames": (1,)}, r"frames = \(1,\): expected"),
        ({"camera": 5.5}, "camera: expected a Camera, got 5.5"),
        ({"aov": []}, "aov: name at least one image"),
        ({"aov": "nothing"}, "image 'nothing': choose of"),
        ({"scheduler": "box"}, "'box': expected local"),
    ],
)
def test_what_makes_no_film_is_refused_in_python(
    tmp_path: Path, given: dict[str, Any], said: str
) -> None:
    with pytest.raises(ValueError, match=said):
        ssdo_gl.render_film("corner", tmp_path / "film", **{"frames": (0, 2), **given})
    assert list(tmp_path.iterdir()) == []
