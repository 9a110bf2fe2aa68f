"""Notices that a scene file changes, so that it is read again."""

from __future__ import annotations

import os
import time

# How often it is looked at, seconds: a person switching from an editor to the window
# takes longer.
LOOK_EVERY_S = 0.5


class FileWatch:
    """Notices that the one file one is interested in was written."""

    def __init__(self) -> None:
        self._path = ""
        self._state: tuple[int, int] | None = None
        self._looked_at = 0.0

    def poll(self, path: str) -> bool:
        """Return whether `path` has changed since the last look at it."""
        now = time.monotonic()
        if path == self._path and now < self._looked_at + LOOK_EVERY_S:
            return False
        self._looked_at = now
        try:
            status = os.stat(path)
        except OSError:
            # No file at all, or one that an editor is just about to replace.
            return False
        state = status.st_mtime_ns, status.st_size
        is_known, before = path == self._path and self._state is not None, self._state
        self._path, self._state = path, state
        return is_known and state != before
