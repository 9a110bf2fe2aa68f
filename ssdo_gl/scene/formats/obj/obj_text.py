"""Lines of .obj and .mtl files, whatever ends them and whatever their encoding."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ssdo_gl.scene.files import read_file


def logical_lines(path: Path, where: str) -> Iterator[tuple[int, str]]:
    """Yield number and text of each line, those joined that end with a backslash.

    But for comments: one that ends with a folder's name would take a vertex with it.

    Raises
    ------
    SceneError
        If the file cannot be read.
    """
    data = read_file(path, where)
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        data = data.decode("utf-16", "replace").encode()
    data = data.removeprefix(b"\xef\xbb\xbf").replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    try:
        lines = data.decode("utf-8").split("\n")
    except UnicodeDecodeError:
        lines = [_decoded(line) for line in data.split(b"\n")]
    pending: list[str] = []
    for number, line in enumerate(lines, 1):
        goes_on = line.endswith("\\") or line.rstrip().endswith("\\")
        if goes_on and (pending or not line.lstrip().startswith("#")):
            pending.append(line.rstrip()[:-1])
            continue
        if pending:
            line = " ".join([*pending, line])
            pending = []
        yield number, line
    if pending:
        yield len(lines), " ".join(pending)


def _decoded(line: bytes) -> str:
    """Return the text of a line; the same bytes give the same text in every file."""
    try:
        return line.decode("utf-8")
    except UnicodeDecodeError:
        return line.decode("latin-1")


def remainder(line: str) -> str:
    """Return what follows the first word of a line."""
    parts = line.split(None, 1)
    return parts[1].strip() if len(parts) > 1 else ""


def without_comment(text: str) -> str:
    """Return a name without a comment behind it."""
    return text.split("#", 1)[0].strip()
