"""A film of five frames, and what files a command has written."""

from __future__ import annotations

from pathlib import Path

FILM = ["--turntable", "--frames-range", "0:5", "--size", "48x27", "--method", "direct", "--quiet"]


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}
