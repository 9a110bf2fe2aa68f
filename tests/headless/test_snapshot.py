"""What a snapshot says of its picture."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from ssdo_gl.cli import main
from ssdo_gl.headless import snapshot

BOX = "[[object]]\nshape = 'box'\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\n"
LAMP = "[[light]]\nkind = 'point'\nposition = [0, 3, 9]\nintensity = [{0}, {0}, {0}]\n"
FROM_INSIDE = "[camera]\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\n"


@pytest.mark.parametrize("suffix", [".png", ".exr"])
@pytest.mark.parametrize(
    ("text", "flags", "is_black"),
    [
        (BOX + LAMP.format(0), [], True),
        (FROM_INSIDE + BOX + LAMP.format(9), [], True),
        (FROM_INSIDE + BOX + LAMP.format(9), ["--camera", "fit"], False),
        (BOX + LAMP.format(0), ["--light", "studio"], False),
        (BOX + LAMP.format(9), [], False),
        (BOX + LAMP.format(0), ["--quiet"], False),
    ],
)
def test_a_black_picture_is_said_to_be_one(
    tmp_path: Path, capsys, suffix: str, text: str, flags: list[str], is_black: bool
) -> None:
    scene, out = tmp_path / "scene.toml", tmp_path / f"out{suffix}"
    scene.write_text(text)
    arguments = [str(scene), "--snapshot", str(out), "--size", "16x9", "--method", "bounce"]
    assert main([*arguments, *flags]) == 0
    assert out.exists()
    assert ("note: the picture is black" in capsys.readouterr().err) == is_black


def test_a_black_picture_of_little_exposure_says_so(capsys, tmp_path: Path) -> None:
    words = [
        "corner",
        "--snapshot",
        str(tmp_path / "a.png"),
        "--size",
        "16x9",
        "--method",
        "direct",
    ]
    assert main([*words, "--exposure", "-60"]) == 0
    assert "the picture is black: at -60 EV, or the camera sees" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("method", "images", "note"),
    [
        ("direct", "bounce,direct,directional", "note: bounce, directional: no part of direct"),
        ("ssao", "bounce", "note: bounce: no part of ssao"),
        ("direct", "visibility,depth", ""),
        ("direct", "all", ""),
        ("bounce", "bounce,emission", ""),
    ],
)
def test_an_image_that_the_method_does_not_make_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], method: str, images: str, note: str
) -> None:
    out = str(tmp_path / "out.npz")
    flags = ["--snapshot", out, "--size", "16x9", "--method", method, "--aov", images]
    assert main(["corner", *flags]) == 0
    said = capsys.readouterr().err
    assert note in said and ("no part of" in said) == bool(note)


def test_ctrl_c_between_two_pictures_waits_for_the_second(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    write = snapshot.write_atomically

    def pressed(*arguments: object) -> None:
        write(*arguments)  # type: ignore[arg-type]
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(snapshot, "write_atomically", pressed)
    both = [tmp_path / "a.png", tmp_path / "a-depth.png"]
    words = ["corner", "--snapshot", str(both[0]), "--aov", "beauty,depth", "--size", "16x9"]
    assert main([*words, "--method", "direct"]) == 130
    told = f"ssdo-gl: interrupted after {both[0]}, {both[1]} had been written\n"
    assert capsys.readouterr().err == told
    assert sorted(tmp_path.iterdir()) == sorted(both)
