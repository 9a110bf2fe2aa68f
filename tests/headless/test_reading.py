"""What one sees while a large scene is read."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import pytest

from ssdo_gl.headless import reading
from ssdo_gl.headless.reading import read_scene
from ssdo_gl.settings.loading import USUAL

SPHERE = "[[object]]\nshape = 'sphere'\nradius = 1\n"


class Stream(io.StringIO):
    def __init__(self, *, is_terminal: bool) -> None:
        super().__init__()
        self.is_terminal = is_terminal

    def isatty(self) -> bool:
        return self.is_terminal


@pytest.mark.parametrize(
    ("is_terminal", "quiet", "large", "is_shown"),
    [
        (True, False, 0, True),
        (True, True, 0, False),
        (False, False, 0, False),
        (True, False, 1 << 30, False),
    ],
)
def test_a_large_file_shows_a_bar_on_a_terminal_alone(
    is_terminal: bool,
    quiet: bool,
    large: int,
    is_shown: bool,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    (tmp_path / "a[red].toml").write_text(SPHERE)
    stream = Stream(is_terminal=is_terminal)
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(reading, "LARGE_FILE", large)
    assert read_scene(str(tmp_path / "a[red].toml"), USUAL, quiet=quiet).triangle_count > 0
    assert ("reading a[red].toml" in stream.getvalue()) == is_shown
    assert is_shown or not stream.getvalue()
