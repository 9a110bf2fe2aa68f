"""The scene of a command: of a file, or from standard input."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ssdo_gl.options.flags import STREAM
from ssdo_gl.scene.formats import read_description
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.scene.scene_error import SceneError
from ssdo_gl.settings.loading import LoadOptions
from ssdo_gl.wording import printable

# Files from here on take seconds.
LARGE_FILE = 20_000_000
# Nobody writes a longer scene; a stream that never ends would fill the memory.
LONGEST_INPUT = 1 << 26


def read_scene(source: str, options: LoadOptions, *, quiet: bool) -> Scene:
    """Read a scene; on a terminal a bar shows how long a large file takes.

    Raises
    ------
    SceneError, SettingError
        One line that says what is wrong.
    """
    if source != STREAM:
        with _waiting(source, quiet=quiet):
            return load_scene(source, options)
    if sys.stdin is None or sys.stdin.isatty():
        state = "closed" if sys.stdin is None else "a terminal"
        raise SceneError(f"-: standard input is {state}: pipe a TOML scene into it")
    options.check_scene(source)
    return read_description(_standard_input(), "standard input", Path.cwd() / "-", options)


def _standard_input() -> str:
    try:
        data = sys.stdin.buffer.read(LONGEST_INPUT + 1)
    except OSError as error:
        raise SceneError(f"-: standard input cannot be read: {error.strerror}") from None
    if len(data) > LONGEST_INPUT:
        raise SceneError(f"-: standard input is longer than {LONGEST_INPUT} bytes: no scene")
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        raise SceneError(f"standard input: byte {error.start} is not UTF-8") from None


@contextmanager
def _waiting(source: str, *, quiet: bool) -> Iterator[None]:
    try:
        size = os.path.getsize(source)
    except (OSError, ValueError):  # what is wrong with it, reading says
        size = 0
    if quiet or size < LARGE_FILE or not sys.stderr.isatty():
        yield
        return
    from ssdo_gl.progress import waiting

    with waiting(f"reading {printable(Path(source).name)}"):
        yield
