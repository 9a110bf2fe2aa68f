"""Notices that files change: shaders are compiled again, scenes are read again."""

from __future__ import annotations

import os
import time
from pathlib import Path

from ssdo_gl import resources
from ssdo_gl.gpu.shader import ShaderError, ShaderLibrary

# How often files are looked at, seconds: a person switching from an editor to the window
# takes longer.
LOOK_EVERY_S = 0.5


class ShaderWatch:
    """Watches a folder of shaders for changes.

    Parameters
    ----------
    library : ShaderLibrary
        Whose programs follow the files.
    root : Path or None
        The folder; None where shaders are not files (a zipped installation).

    Attributes
    ----------
    faults : tuple of str
        What does not compile at present, as ``file:line: message``; the last good
        program of each goes on drawing.
    """

    def __init__(self, library: ShaderLibrary, root: Path | None) -> None:
        self.faults: tuple[str, ...] = ()
        self._library = library
        self._root = root
        self._state = self._look()
        self._looked_at = time.monotonic()

    def poll(self) -> bool:
        """Compile anew if a file has changed since the last look; return whether it did."""
        now = time.monotonic()
        if now < self._looked_at + LOOK_EVERY_S:
            return False
        self._looked_at = now
        state = self._look()
        if state == self._state:
            return False
        self._state = state
        self.reload()
        return True

    def reload(self) -> None:
        """Compile anew whatever differs from what is in use."""
        self._state = self._look()
        faults: list[ShaderError] = self._library.reload()
        # One broken include breaks many programs, all with the same message.
        self.faults = tuple(dict.fromkeys(str(fault) for fault in faults))

    def _look(self) -> dict[str, int]:
        """Return when each file was changed last, nanoseconds."""
        if self._root is None:
            return {}
        state = {}
        for path in sorted(self._root.rglob("*")):
            try:
                state[str(path)] = path.stat().st_mtime_ns
            except OSError:
                # An editor replaces a file by removing it first; the next look finds it.
                continue
        return state


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


def shader_folder() -> Path | None:
    """Return the folder of the shipped shaders, if they are files."""
    folder = Path(str(resources.folder("shaders")))
    return folder if folder.is_dir() else None
