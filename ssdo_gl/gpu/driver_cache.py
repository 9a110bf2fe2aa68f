"""Keeps Mesa from its shader cache where the disk has no room for it."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

# Mesa maps the cache's index into memory, 2^16 entries of 20 bytes in a file full of holes: a
# page that the disk cannot hold ends the process with SIGBUS.
_ROOM_BYTES = 1 << 22
_DISABLE = "MESA_SHADER_CACHE_DISABLE"


def leave_full_disk_alone() -> None:
    """Switch the driver's cache off, for this process, if its folder's disk is full."""
    if _DISABLE in os.environ:
        return
    folder = _folder()
    try:
        there = next(path for path in (folder, *folder.parents) if path.is_dir())
        has_room = shutil.disk_usage(there).free >= _ROOM_BYTES
    except OSError:
        return  # whatever is wrong there, the driver finds out, too
    if not has_room:
        os.environ[_DISABLE] = "true"


def _folder() -> Path:
    """Return where Mesa keeps its cache."""
    chosen = os.environ.get("MESA_SHADER_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME")
    return Path(chosen) if chosen else Path(os.path.expanduser("~")) / ".cache"
