"""Signals and lost streams: no traceback, no half-written file, an honest exit code."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from ssdo_gl.process import EXIT_BROKEN_PIPE, exit_code, signals_as_exceptions, steadfast_output

COMMAND = [sys.executable, "-m", "ssdo_gl", "corner", "--size", "16x9", "--samples", "4"]


class Faulty(io.StringIO):
    """A stream whose reader has left, or whose disk is full."""

    def __init__(self, error: OSError) -> None:
        super().__init__()
        self.error = error

    def write(self, text: str) -> int:
        raise self.error


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (BrokenPipeError(32, "Broken pipe"), EXIT_BROKEN_PIPE, ""),
        (OSError(28, "No space left on device"), 0, "No space left on device"),
    ],
)
def test_lost_output_ends_no_work(monkeypatch, capsys, error, code, said):
    monkeypatch.setattr(sys, "stdout", Faulty(error))
    steps = []
    with steadfast_output() as out:
        print("said to nobody")
        steps.append("went on")
        code_of_all = exit_code(0, out)
    assert steps == ["went on"] and code_of_all == code
    assert said in capsys.readouterr().err


def test_a_fault_of_the_command_is_not_hidden_by_a_lost_stream(monkeypatch):
    monkeypatch.setattr(sys, "stdout", Faulty(BrokenPipeError(32, "Broken pipe")))
    with steadfast_output() as out:
        print("said to nobody")
        assert exit_code(2, out) == 2


def test_letters_that_a_terminal_lacks_are_written_as_escapes(monkeypatch):
    raw = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(raw, encoding="ascii"))
    with steadfast_output():
        print("caf\u00e9.png")
    assert raw.getvalue() == b"caf\\xe9.png\n"


def test_streams_come_back(monkeypatch):
    before = sys.stdout, sys.stderr
    with steadfast_output():
        assert sys.stdout is not before[0]
    assert (sys.stdout, sys.stderr) == before


def test_closed_streams_are_none(monkeypatch):
    monkeypatch.setattr(sys, "stderr", None)
    with steadfast_output():
        print("to nobody", file=sys.stderr)


def test_a_signal_unwinds_the_stack_and_handlers_come_back():
    before = signal.getsignal(signal.SIGTERM)
    undone = []
    with pytest.raises(SystemExit) as stop, signals_as_exceptions():
        try:
            os.kill(os.getpid(), signal.SIGTERM)
            time.sleep(10.0)
        finally:
            undone.append(True)
    assert stop.value.code == 128 + signal.SIGTERM and undone == [True]
    assert signal.getsignal(signal.SIGTERM) is before


def run(arguments: str) -> subprocess.CompletedProcess[str]:
    """Run the command in a shell, with what `arguments` do to its streams."""
    line = " ".join([*(f"'{word}'" for word in COMMAND), arguments])
    return subprocess.run(["bash", "-c", line], capture_output=True, text=True, timeout=120)


@pytest.mark.parametrize(
    ("streams", "codes"),
    [(">/dev/full", {0}), ("| true; exit ${PIPESTATUS[0]}", {0, 141}), ("2>&-", {0})],
)
def test_picture_is_written_whatever_becomes_of_the_messages(tmp_path, streams, codes):
    out = tmp_path / "a.png"
    result = run(f"--snapshot '{out}' {streams}")
    assert result.returncode in codes, result
    assert out.stat().st_size > 0
    assert "Traceback" not in result.stderr and "Exception" not in result.stderr


@pytest.mark.parametrize(
    "words", ["--help", "--version", "--list-scenes", "--explain", "--explain --snapshot '{out}'"]
)
def test_what_is_there_to_be_read_must_not_be_lost(tmp_path, words):
    result = run(f"{words.format(out=tmp_path / 'a.png')} >/dev/full")
    assert result.returncode == 2, result
    lines = result.stderr.splitlines()
    assert lines == ["ssdo-gl: standard output: [Errno 28] No space left on device"]


def interrupted(number: int, tmp_path: Path, code: str) -> subprocess.CompletedProcess[bytes]:
    """Run the command with a signal to itself where `code` calls ``strike()``."""
    lines = [
        "import os, sys",
        f"strike = lambda: os.kill(os.getpid(), {int(number)})",
        "from ssdo_gl.__main__ import main",
        code,
        f"sys.exit(main({[*COMMAND[3:], '--snapshot', str(tmp_path / 'a.npz')]!r}))",
    ]
    return subprocess.run(
        [sys.executable, "-c", "\n".join(lines)], capture_output=True, timeout=120
    )


def test_signals_are_heard_before_anything_is_imported():
    code = "import sys, ssdo_gl.__main__; print([n for n in sys.modules if n[:8] == 'ssdo_gl.'])"
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=120
    )
    assert result.stdout == "['ssdo_gl.__main__']\n", result.stderr


def test_next_to_nothing_is_imported_before_interrupts_are_handled():
    """Ctrl-C in a tenth of a second of `typing`, `enum` and `re` was a traceback."""
    code = (
        "import __future__, os, sys; sys.path = sys.argv[1:]; before = {*sys.modules}\n"
        "import ssdo_gl.__main__\n"
        "print(sorted({*sys.modules} - before - {'gc'}))"
    )
    result = subprocess.run(
        [sys.executable, "-I", "-S", "-c", code, *sys.path],
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert result.stdout == "['ssdo_gl', 'ssdo_gl.__main__']\n", result.stderr


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_of_the_imports_is_one_line(tmp_path, number):
    result = interrupted(
        number,
        tmp_path,
        "import builtins\n"
        "real = builtins.__import__\n"
        "def hooked(name, *rest):\n"
        "    if name == 'numpy':\n"
        "        strike()\n"
        "    return real(name, *rest)\n"
        "builtins.__import__ = hooked",
    )
    assert result.returncode == 128 + number
    assert result.stderr == b"ssdo-gl: interrupted; nothing was written\n"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_while_a_file_is_written_leaves_all_of_it(tmp_path, number):
    """Ctrl-C says so; what stands beside the target until it is complete goes."""
    result = interrupted(
        number,
        tmp_path,
        "from pathlib import Path\n"
        "real = Path.replace\n"
        "Path.replace = lambda *paths: (strike(), real(*paths))[1]",
    )
    out = tmp_path / "a.npz"
    assert result.returncode == 128 + number, result.stderr
    told = f"interrupted after {out} had been written" if number == signal.SIGINT else "terminated"
    assert result.stderr.decode() == f"ssdo-gl: {told}\n"
    assert list(tmp_path.iterdir()) == [out]
    with np.load(out) as arrays:
        assert arrays["beauty"].shape == (9, 16, 4)


# The command waits until it ends.
ENDED = {
    # Python drops what is raised in a finalizer.
    "a finalizer": """
class Waste:
    def __del__(self):
        strike()
def render(*words, **options):
    Waste()
    while True:
        time.sleep(0.01)
""",
    # As the locks of Python's imports do, in whose `finally` a KeyError takes its place.
    "what it breaks": """
def render(*words, **options):
    try:
        strike()
        time.sleep(60.0)
    finally:
        {}.pop('lock')
""",
}


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("where", ENDED)
def test_an_interrupt_ends_the_command_without_a_traceback(tmp_path, number, where):
    lines = ["import time", "from ssdo_gl.renderer import Renderer", ENDED[where]]
    result = interrupted(number, tmp_path, "\n".join([*lines, "Renderer.render = render"]))
    assert result.returncode == 128 + number, result.stderr
    assert b"ignored" not in result.stderr and b"Traceback" not in result.stderr
    assert list(tmp_path.iterdir()) == []
