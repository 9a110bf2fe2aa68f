"""Many scenes in one command: the pictures of snapshots, whatever is wrong with some."""

from __future__ import annotations

import io
import signal
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from glb_writer import GlbWriter

from ssdo_gl.cli import main
from ssdo_gl.farm import scenes
from ssdo_gl.farm.scenes import Said
from ssdo_gl.gpu import warm_device
from ssdo_gl.headless import snapshot
from ssdo_gl.options.flags import CommandLine
from ssdo_gl.renderer import Renderer

FLAGS = ["--size", "48x27", "--method", "direct"]
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


@pytest.fixture(autouse=True)
def models(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two models, and one that is none, in the current folder."""
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "m"
    folder.mkdir()
    (folder / "big.obj").write_text(TRIANGLE.replace(" 1 0 0", " 9 0 0"))
    (folder / "bad.glb").write_text("junk")
    (folder / "small.obj").write_text(TRIANGLE)
    return folder


def contents(folder: str) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in Path(folder).iterdir()}


@pytest.mark.parametrize(
    ("out", "more"),
    [
        ("{name}.png", ["--aov", "beauty,depth", "--method", "gi"]),
        ("{name}.webp", ["--preset", "fast"]),
        ("{name}.exr", ["--camera", "1,2,3 0,0,0"]),
        ("{name}.npz", ["--aov", "visibility", "--method", "ssao"]),
    ],
)
def test_pictures_are_those_of_snapshots(
    out: str, more: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    flags = [*FLAGS, *more]
    assert main(["--batch", "m/*", "corner", "--out", f"out/{out}", *flags]) == 2
    said = capsys.readouterr()
    assert said.err == "ssdo-gl: m/bad.glb: not a GLB file: it does not start with 'glTF'\n"
    assert said.out.startswith(f"out/{out}: 3 pictures, 1 could not be made, ")
    assert said.out.count("\n") == 1
    Path("one").mkdir()
    for scene in ("m/big.obj", "m/small.obj", "corner"):
        name = out.format(name=Path(scene).stem)
        assert main([scene, "--snapshot", f"one/{name}", *flags, "--quiet"]) == 0
    assert contents("out") == contents("one")


def test_shaders_are_compiled_once(monkeypatch: pytest.MonkeyPatch) -> None:
    made = []
    create = warm_device.create_context
    monkeypatch.setattr(warm_device, "create_context", lambda b: made.append(b) or create(b))
    assert main(["--batch", "m/*.obj", "--out", "out", *FLAGS, "--quiet"]) == 0
    assert len(made) == 1
    assert main(["m/big.obj", "m/small.obj", "--snapshot", "{name}.png", *FLAGS, "--quiet"]) == 0
    assert len(made) == 2


def test_a_scene_that_nothing_foresaw_stops_no_other(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    render = Renderer.render

    def failing(self: Renderer, *arguments: object, **options: object) -> object:
        if self.scene.bounds()[1].max() > 5.0:
            raise ArithmeticError("no such number")
        return render(self, *arguments, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(Renderer, "render", failing)
    assert main(["--batch", "m/*.obj", "--out", "out", *FLAGS]) == 2
    assert capsys.readouterr().err == "ssdo-gl: m/big.obj: ArithmeticError: no such number\n"
    assert list(contents("out")) == ["small.png"]


def test_resume_renders_empty_pictures_anew() -> None:
    words = ["--batch", "m/*.obj", "--out", "out", *FLAGS]
    assert main(words) == 0
    whole = contents("out")
    Path("out/big.png").write_bytes(b"")
    assert main([*words, "--resume"]) == 0
    assert contents("out") == whole


def test_resume_renders_the_missing_pictures_alone(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--batch", "m/*.obj", "corner", "--out", "out", "--aov", "beauty,depth", *FLAGS]
    assert main(words) == 0
    whole = contents("out")
    Path("out/small-depth.png").unlink()
    Path("out/big.png").write_bytes(b"kept")
    capsys.readouterr()
    assert main([*words, "--resume"]) == 0
    assert capsys.readouterr().out.startswith("out: 1 picture, 2 were there, ")
    assert contents("out") == whole | {"big.png": b"kept"}
    assert main([*words, "--resume", "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize("method", ["direct", "reference-near"])
def test_ctrl_c_leaves_whole_pictures(
    method: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of a reference, what it had reached would pass for a whole one under --resume."""
    words = ["--batch", "m/*.obj", "corner", "--out", "out", "--size", "48x27"]
    words += [] if method == "direct" else ["--spp", "4"]
    render, drawn = Renderer.render, []

    def pressed(self: Renderer, *arguments: object, **options: object) -> object:
        drawn.append(1)
        if len(drawn) < 2:
            return render(self, *arguments, **options)  # type: ignore[arg-type]
        if method == "direct":
            signal.raise_signal(signal.SIGINT)
        result = render(self, *arguments, **options)  # type: ignore[arg-type]
        object.__setattr__(result, "partial", True)
        return result

    with monkeypatch.context() as patch:
        patch.setattr(Renderer, "render", pressed)
        assert main([*words, "--method", method]) == 130
    assert "ssdo-gl: interrupted; out has 1 of the 3 pictures\n" in capsys.readouterr().err
    assert list(contents("out")) == ["big.png"]
    assert main([*words, "--method", method, "--resume"]) == 0
    assert sorted(contents("out")) == ["big.png", "corner.png", "small.png"]


def test_ctrl_c_counts_pictures_that_workers_have_not_told_of(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def early(commands: Sequence[CommandLine], work: object) -> Iterator[Said]:
        Path("out/small.png").write_bytes(b"whole")
        yield Said(0)
        raise KeyboardInterrupt

    Path("out").mkdir()
    Path("out/corner.png").write_bytes(b"old")
    Path("out/stairs.png").touch()
    monkeypatch.setattr(scenes, "_captured", early)
    words = ["--batch", "m/big.obj", "m/small.obj", "corner", "stairs", "--out", "out"]
    assert main(words) == 130
    assert "interrupted; out has 2 of the 4 pictures" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("flags", "told"),
    [
        ([], "interrupted; of m/small.obj nothing was written\n"),
        (["--scheduler", "local:1"], "interrupted; 1 of the 2 scenes had been rendered\n"),
    ],
)
def test_ctrl_c_does_not_deny_the_scenes_before(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], flags: list[str], told: str
) -> None:
    render, drawn = Renderer.render, []

    def pressed(self: Renderer, *arguments: object, **options: object) -> object:
        drawn.append(1)
        if len(drawn) > 1:
            raise KeyboardInterrupt
        return render(self, *arguments, **options)  # type: ignore[arg-type]

    def early(commands: Sequence[CommandLine], work: object) -> Iterator[Said]:
        yield Said(0)
        raise KeyboardInterrupt

    monkeypatch.setattr(Renderer, "render", pressed)
    monkeypatch.setattr(scenes, "_captured", early)
    words = ["m/big.obj", "m/small.obj", "--snapshot", "{name}.png", *FLAGS]
    assert main([*words, *flags]) == 130
    assert capsys.readouterr().err.endswith(f"ssdo-gl: {told}")


def test_ctrl_c_while_a_picture_is_written_leaves_it_whole(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write = snapshot.write_atomically

    def late(*arguments: object) -> None:
        signal.raise_signal(signal.SIGINT)
        write(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(snapshot, "write_atomically", late)
    words = ["--batch", "m/*.obj", "--out", "out", "--aov", "beauty,depth", *FLAGS]
    assert main(words) == 130
    assert "interrupted; out has 1 of the 2 pictures" in capsys.readouterr().err
    assert sorted(contents("out")) == ["big-depth.png", "big.png"]


def test_a_terminal_shows_how_far_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    monkeypatch.setenv("TERM", "xterm")
    terminal = Terminal()
    with monkeypatch.context() as patch:
        patch.setattr(sys, "stderr", terminal)
        assert main(["--batch", "m/*", "--out", "out", *FLAGS]) == 2
    shown = terminal.getvalue()
    assert "pictures" in shown and "100%" in shown and "0:00:00" in shown
    assert "m/bad.glb: not a GLB file" in shown


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["m/*", "--out", "no/such/{name}.png"], "the folder no does not exist"),
        (["m/*", "--out", "out/{name}.bmp"], "the suffix must be one of .png"),
        (["m/*", "--out", "m/big.obj"], "m/big.obj is a file, no folder"),
        (["m/*", "--out", "out", "--methode", "gi"], "unrecognized arguments: --methode"),
        (["m/*", "--out", "out", "--camera", "1,2"], "'1,2': expected fit, the name of"),
    ],
)
def test_what_cannot_be_is_refused_before_anything_is_made(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--batch", *words]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1 and said in lines[0]
    assert sorted(path.name for path in Path().iterdir()) == ["m"]


def test_a_camera_is_looked_for_in_each_file(capsys: pytest.CaptureFixture[str]) -> None:
    glb = GlbWriter()
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    glb.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 1}}]
    glb.json["nodes"] = [{"mesh": 0}, {"camera": 0, "name": "Front", "translation": [0, 0, 4]}]
    glb.json["scenes"] = [{"nodes": [0, 1]}]
    glb.save(Path("m/bad.glb"))
    words = ["--batch", "m/*", "--out", "out", "--camera", "Front", *FLAGS, "--quiet"]
    assert main(words) == 2
    lines = capsys.readouterr().err.splitlines()
    assert lines == [
        f"ssdo-gl: camera 'Front': m/{name}.obj has no cameras" for name in ("big", "small")
    ]
    assert sorted(contents("out")) == ["bad.png"]
