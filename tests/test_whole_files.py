"""Files that are replaced whole, whatever happens meanwhile."""

from __future__ import annotations

import os
import stat
import sys
from itertools import count
from pathlib import Path

import pytest

from ssdo_gl.whole_files import replace_whole


class Signal(BaseException):
    """What a signal's handler raises."""


def struck(step: int, path: Path) -> bool:
    """Replace `path` by b"new" with a signal at the step-th bytecode; whether one was so late."""
    left = step

    def trace(frame, event, _argument):
        nonlocal left
        frame.f_trace_opcodes = True
        if event == "opcode":
            if not left:
                sys.settrace(None)
                raise Signal
            left -= 1
        return trace

    sys.settrace(trace)
    try:
        replace_whole(path, b"new")
    except Signal:
        return True
    finally:
        sys.settrace(None)
    return False


# A file that a signal met as it was opened is closed with the last reference to it.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_signal_at_any_moment_leaves_the_old_file_or_the_new_one_alone(tmp_path):
    path = tmp_path / "a.png"
    found = set()
    for step in count():
        path.write_bytes(b"old")
        was_struck = struck(step, path)
        assert [entry.name for entry in tmp_path.iterdir()] == ["a.png"], step
        found.add(path.read_bytes())
        if not was_struck:
            break
    assert step > 50 and found == {b"old", b"new"}


def test_a_file_has_the_rights_that_any_new_file_has(tmp_path):
    before = os.umask(0o027)
    try:
        replace_whole(tmp_path / "a.png", b"new")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "a.png").stat().st_mode) == 0o640


def test_a_failure_leaves_nothing_beside_the_old_file(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "inside").touch()
    with pytest.raises(OSError, match="director"):
        replace_whole(tmp_path / "a", b"new")
    assert [entry.name for entry in tmp_path.iterdir()] == ["a"]
