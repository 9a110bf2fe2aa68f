"""What a snapshot says of its picture."""

from __future__ import annotations

from pathlib import Path

import pytest

from ssdo_gl.cli import main

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
