"""Files that are replaced whole, in one step, or not at all."""

from __future__ import annotations

import errno
import os
import secrets
from pathlib import Path

SPECIAL = "is a pipe or a device; name a file"


def has_data(path: Path) -> bool:
    """Return whether `path` is a file of more than no bytes, which others leave of a full disk."""
    try:
        return path.is_file() and path.stat().st_size > 0
    except OSError:
        return False


def is_special(path: Path) -> bool:
    """Return whether `path` leads to something that is no file and no folder."""
    return os.path.exists(path) and not (os.path.isfile(path) or os.path.isdir(path))


def replace_whole(path: Path, data: bytes) -> None:
    """Replace `path` by `data`; a failure or a signal leaves the old file untouched.

    Raises
    ------
    OSError
        Also of pipes and devices: who is root would replace /dev/null by a picture.
    """
    if is_special(path):
        raise OSError(errno.EINVAL, SPECIAL)
    # Named before it is made: a signal between the two would leave it behind. Not after the
    # file: a name may be as long as the file system allows.
    temporary = path.with_name(f".ssdo-gl-{secrets.token_hex(8)}")
    try:
        with temporary.open("xb") as file:
            file.write(data)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
