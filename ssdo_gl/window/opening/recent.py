"""The files that were opened last, kept from one visit to the next."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

from ssdo_gl.images.files import OutputError, write_atomically

MOST = 10


def usual_file() -> Path:
    """Return where the system wants such things to be kept."""
    home = Path.home()
    if sys.platform == "win32":
        folder = Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local")
    elif sys.platform == "darwin":
        folder = home / "Library" / "Application Support"
    else:
        folder = Path(os.environ.get("XDG_STATE_HOME") or home / ".local" / "state")
    return folder / "ssdo_gl" / "recent.json"


class Recent:
    """Paths, the newest first.

    Parameters
    ----------
    file : Path or None
        Where they are kept; None: where the system wants it.
    """

    def __init__(self, file: Path | None = None) -> None:
        self._file = file or usual_file()

    def paths(self) -> list[str]:
        """Return those that still exist."""
        try:
            kept = json.loads(self._file.read_text(encoding="utf-8"))
        # Without the list, or with somebody else's, one begins anew.
        except (OSError, ValueError):
            return []
        known = kept if isinstance(kept, list) else []
        return [path for path in known if isinstance(path, str) and os.path.exists(path)][:MOST]

    def add(self, path: str) -> None:
        """Put a file in front."""
        path = str(Path(path).resolve())
        paths = [path, *(other for other in self.paths() if other != path)][:MOST]
        try:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            write_atomically(self._file, (json.dumps(paths, indent=1) + "\n").encode())
        # A convenience: where it cannot be kept, the file was opened all the same.
        except (OSError, OutputError):
            return
