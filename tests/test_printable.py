"""Nothing that a file holds reaches the terminal as a command."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ssdo_gl import cli
from ssdo_gl.images import files
from ssdo_gl.images.files import OutputError, exr_bytes
from ssdo_gl.wording import printable


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("plain, é, 漢, [red]", "plain, é, 漢, [red]"),
        ("\x1b[31mred\x1b]0;title\x07", "\\x1b[31mred\\x1b]0;title\\x07"),
        ("\x9b31m", "\\x9b31m"),
        ("a\nb\r\tc\x7f", "a\\nb\\r\\tc\\x7f"),
        ("\u202egnp.exe", "\\u202egnp.exe"),
        ("\u2028", "\\u2028"),
        ("\udcff", "\\udcff"),
    ],
)
def test_what_a_terminal_would_obey_is_shown(text: str, shown: str) -> None:
    assert printable(text) == shown


def test_names_in_errors_and_notes_are_cleaned(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl \x1b[31mred\nf 1 2 3\n")
    snapshot = ["--snapshot", str(tmp_path / "a.png"), "--size", "16x16"]
    assert cli.main([str(path), *snapshot]) == 0
    path.write_text("v \x1b[31m 0 0\nf 1 1 1\n")
    assert cli.main([str(path), *snapshot]) == 2
    assert cli.main(["\x1b[31m.obj", *snapshot]) == 2
    out, err = capfd.readouterr()
    assert "\x1b" not in out + err
    assert err.count("\\x1b[31m") >= 2


@pytest.mark.parametrize("closed", [(2,), (1, 2), (0, 1, 2)])
def test_closed_streams_change_nothing(closed: tuple[int, ...], tmp_path: Path) -> None:
    shut = " ".join({0: "<&-", 1: ">&-", 2: "2>&-"}[number] for number in closed)
    command = f"{sys.executable} -m ssdo_gl {{}} --snapshot a.png --size 16x16 {shut}"
    environment = {**os.environ, "PYTHONPATH": str(Path(cli.__file__).parent.parent)}
    for scene, code in (("none.toml", 2), ("furnace", 0)):
        done = subprocess.run(
            command.format(scene),
            shell=True,
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            check=False,
        )
        assert done.returncode == code
        assert b"none.toml" not in done.stdout
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_an_exr_without_room_for_it_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(files.tempfile, "TemporaryDirectory", full)
    with pytest.raises(OutputError, match=r"\(TMPDIR\): .*No space left"):
        exr_bytes({"beauty": np.zeros((2, 2, 3), np.float32)}, {})
