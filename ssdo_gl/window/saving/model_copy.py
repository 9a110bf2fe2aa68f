"""Copies a model to where a scene that is made from it can be written."""

from __future__ import annotations

import struct
from pathlib import Path

from ssdo_gl.images.files import OutputError, write_atomically

# Formats that name no other file.
_WHOLE = (".ply", ".stl", ".off")
# Of a .glb: before its JSON, whose length is the fourth number.
_HEADER = struct.Struct("<5I")


def is_in_one_file(path: Path) -> bool:
    """Return whether a model needs no other file."""
    if path.suffix.lower() in _WHOLE:
        return True
    if path.suffix.lower() != ".glb":
        return False
    try:
        with path.open("rb") as file:
            length = _HEADER.unpack(file.read(_HEADER.size))[3]
            return b'"uri"' not in file.read(length)
    except (OSError, struct.error):
        return False


def copy_of(path: Path, folder: Path) -> Path:
    """Return a copy of `path` in `folder`, the one that is there already, or one that is made.

    Raises
    ------
    OutputError
        If it cannot be made, or another file has its name.
    """
    copy = folder / path.name
    try:
        data = path.read_bytes()
        if copy.exists() and copy.read_bytes() != data:
            raise OutputError(f"{copy}: is another file")
    except OSError as error:
        raise OutputError(f"{path}: cannot be copied: {error.strerror}") from None
    write_atomically(copy, data)
    return copy
