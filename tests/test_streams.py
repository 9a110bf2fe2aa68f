"""The command with pipes, and with several scenes."""

from __future__ import annotations

import errno
import io
import os
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

from ssdo_gl import cli
from ssdo_gl.cli import main

SMALL = ["--size", "16x9", "--samples", "8"]
SCENE = """
[[object]]
shape = "box"
min = [0, 0, 0]
max = [1, 1, 1]
"""


def piped(*arguments, text=b"", stdout=subprocess.PIPE):
    return subprocess.run(
        [sys.executable, "-m", "ssdo_gl", *arguments, *SMALL],
        input=text,
        stdout=stdout,
        stderr=subprocess.PIPE,
        check=False,
    )


def test_from_a_pipe_to_a_pipe(tmp_path):
    file = tmp_path / "scene.toml"
    file.write_text(SCENE)
    assert main([str(file), "--snapshot", str(tmp_path / "a.png"), "--quiet", *SMALL]) == 0
    done = piped("-", "--snapshot", "-", text=SCENE.encode())
    assert done.returncode == 0, done.stderr
    assert done.stderr.startswith(b"note: ") and b"\nstandard output: 16x9" in done.stderr
    assert done.stdout.startswith(b"\x89PNG")
    with Image.open(io.BytesIO(done.stdout)) as ours, Image.open(tmp_path / "a.png") as theirs:
        np.testing.assert_array_equal(np.asarray(ours), np.asarray(theirs))


def test_a_fault_of_a_piped_scene_is_one_line(tmp_path):
    done = piped("-", "--snapshot", str(tmp_path / "a.png"), text=b"title = 3")
    assert done.returncode == 2
    assert done.stderr.count(b"\n") == 1 and b"standard input" in done.stderr
    done = piped("-", "--snapshot", str(tmp_path / "a.png"), text=b"title = '\xff'")
    assert b"standard input: byte 9 is not UTF-8" in done.stderr


def test_a_reader_who_has_left_is_exit_141():
    reading, writing = os.pipe()
    os.close(reading)
    try:
        assert piped("corner", "--snapshot", "-", stdout=writing).returncode == 141
    finally:
        os.close(writing)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["-", "--explain"], "standard input is a terminal"),
        (["corner", "--snapshot", "-"], "standard output is a terminal"),
    ],
)
def test_a_terminal_is_refused(monkeypatch, capsys, arguments, said):
    monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)
    monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
    assert main(arguments) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("stream", "arguments", "said"),
    [
        ("sys.stdin", ["-", "--explain"], "standard input is closed"),
        ("sys.stdout", ["corner", "--snapshot", "-"], "standard output is closed"),
    ],
)
def test_a_closed_stream_is_said_to_be_closed(monkeypatch, capsys, stream, arguments, said):
    monkeypatch.setattr(stream, None)
    assert main(arguments) == 2
    assert said in capsys.readouterr().err


class Endless(io.RawIOBase):
    """What `yes` sends: it never ends, as far as memory allows."""

    left = 1 << 28

    def readable(self):
        return True

    def readinto(self, buffer):
        self.left -= len(buffer)
        if self.left < 0:
            raise MemoryError
        buffer[:] = b"#" * len(buffer)
        return len(buffer)


def test_an_endless_input_is_refused_before_it_fills_the_memory(monkeypatch, capsys):
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BufferedReader(Endless())))
    assert main(["-", "--explain"]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "standard input is longer than 67108864 bytes" in said


def test_an_input_that_cannot_be_read_is_one_line(monkeypatch, capsys):
    def faulty(_self, _buffer):
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr(Endless, "readinto", faulty)
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BufferedReader(Endless())))
    assert main(["-", "--explain"]) == 2
    said = capsys.readouterr().err
    assert said == "ssdo-gl: -: standard input cannot be read: Input/output error\n"


def test_standard_output_takes_one_image(capsys):
    assert main(["corner", "--snapshot", "-", "--aov", "beauty,depth"]) == 2
    assert "takes one image" in capsys.readouterr().err


def test_a_bad_scene_does_not_stop_the_others(tmp_path, capsys):
    command = ["corner", "nosuch.glb", "stairs", "--snapshot", f"{tmp_path}/", *SMALL]
    assert main(command) == 2
    assert {path.name for path in tmp_path.iterdir()} == {"corner.png", "stairs.png"}
    captured = capsys.readouterr()
    assert "ssdo-gl: nosuch.glb: no such file\n" in captured.err
    assert [line for line in captured.out.splitlines() if line in ("corner:", "stairs:")]


def test_a_fault_of_flags_is_said_once(tmp_path, capsys):
    assert main(["corner", "stairs", "--snapshot", f"{tmp_path}/", "--samples", "0"]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("codes", "expected"), [((0, 4, 0), 4), ((4, 2, 0), 2), ((2, 3, 4), 3), ((0, 130, 2), 130)]
)
def test_the_worst_code_counts(monkeypatch, capsys, tmp_path, codes, expected):
    left = list(codes)
    monkeypatch.setattr(cli, "carry_out", lambda *_, **__: left.pop(0))
    assert main(["a", "b", "c", "--snapshot", f"{tmp_path}/"]) == expected
    assert len(left) == (1 if expected == 130 else 0)
