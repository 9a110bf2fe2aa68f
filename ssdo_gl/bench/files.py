"""Files of a bench: written whole or not at all; caches where the system keeps them."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any

from ssdo_gl.whole_files import replace_whole


class BenchError(ValueError):
    """A bench that cannot run: one line naming the path or setting and the cure."""


def cache_folder(kind: str) -> Path:
    """Return the user's cache folder for `kind`, created if need be.

    ``SSDO_GL_CACHE`` names another place; else the convention of the system holds.
    """
    chosen = os.environ.get("SSDO_GL_CACHE")
    if chosen:
        base = Path(chosen)
    elif sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA", str(Path.home()))) / "ssdo_gl"
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches" / "ssdo_gl"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "ssdo_gl"
    folder = base / kind
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BenchError(
            f"{folder}: cannot be created ({error.strerror}); set SSDO_GL_CACHE to another folder"
        ) from None
    return folder


def replace_file(path: Path, data: bytes) -> None:
    """Replace `path` by `data` in one step; a failure leaves the old file untouched."""
    try:
        replace_whole(path, data)
    except OSError as error:
        raise BenchError(f"{path}: cannot be written: {error.strerror}") from None


def replace_json(path: Path, content: Any) -> None:
    """Replace `path` by `content` as indented JSON."""
    replace_file(path, (json.dumps(content, indent=1, sort_keys=True) + "\n").encode())


def append_line(path: Path, line: str) -> None:
    """Append one line in a single write, so that a killed run loses at most that line."""
    if "\n" in line:
        raise ValueError("a line holds no line break")
    try:
        handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
        try:
            os.write(handle, line.encode() + b"\n")
        finally:
            os.close(handle)
    except OSError as error:
        raise BenchError(f"{path}: cannot be written: {error.strerror}") from None


def whole_lines(path: Path) -> list[str]:
    """Return the lines of `path`; one that a killed run left unfinished is cut off.

    The cut is made in the file, too, so that the next line does not continue it.
    """
    if not path.exists():
        return []
    data = path.read_bytes()
    end = data.rfind(b"\n") + 1
    if end != len(data):
        replace_file(path, data[:end])
    return data[:end].decode().splitlines()
