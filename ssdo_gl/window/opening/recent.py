"""The files that were opened last, kept from one visit to the next."""

from __future__ import annotations

import os
from pathlib import Path

from ssdo_gl.window.kept_files import keep, kept, usual_file

MOST = 10


class Recent:
    """Paths, the newest first.

    Parameters
    ----------
    file : Path or None
        Where they are kept; None: where the system wants it.
    """

    def __init__(self, file: Path | None = None) -> None:
        self._file = file or usual_file("recent.json")

    def paths(self) -> list[str]:
        """Return those that still exist."""
        known = kept(self._file)
        known = known if isinstance(known, list) else []
        return [path for path in known if isinstance(path, str) and os.path.exists(path)][:MOST]

    def add(self, path: str) -> None:
        """Put a file in front."""
        path = str(Path(path).resolve())
        keep(self._file, [path, *(other for other in self.paths() if other != path)][:MOST])
