"""What no file of the project may hold: unfinished work."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parent.parent
FOLDERS = ("ssdo_gl", "shaders", "scenes", "tests", "docs", "benchmarks", ".ci", ".github")
SUFFIXES = {".py", ".glsl", ".frag", ".vert", ".toml", ".md", ".yml", ".yaml", ".sh", ""}
UNFINISHED = re.compile(r"\b(TODO|FIXME|XXX|HACK)\b|NotImplementedError")


def project_files() -> list[Path]:
    """Return the project's own text files, shipped or not."""
    files = [path for path in ROOT.iterdir() if path.is_file()]
    for folder in FOLDERS:
        files += (path for path in (ROOT / folder).rglob("*") if path.is_file())
    # This file has to name what it forbids.
    own = Path(__file__)
    return [p for p in files if p.suffix in SUFFIXES and "__pycache__" not in p.parts and p != own]


def unfinished(text: str) -> list[int]:
    """Return the numbers of the lines that name unfinished work."""
    return [i for i, line in enumerate(text.splitlines(), 1) if UNFINISHED.search(line)]


def test_no_file_names_unfinished_work():
    found = [
        f"{path.relative_to(ROOT)}:{line}"
        for path in project_files()
        for line in unfinished(path.read_text(encoding="utf-8"))
    ]
    assert found == []


def test_unfinished_work_would_be_found():
    assert unfinished("a\n# TODO: later\n") == [2]
    assert unfinished("raise NotImplementedError") == [1]
    assert unfinished("the mastodon and the toadstool") == []
