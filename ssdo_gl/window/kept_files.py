"""What a window keeps from one visit to the next, files opened last too: small files of JSON."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any

from ssdo_gl.images.files import OutputError, write_atomically
from ssdo_gl.process import home_folder

# Files opened last.
MOST = 10


def usual_file(name: str) -> Path | None:
    """Return where the system wants such a thing to be kept; None: nowhere."""
    variable, *usual = {
        "win32": ("LOCALAPPDATA", "AppData", "Local"),
        "darwin": ("", "Library", "Application Support"),
    }.get(sys.platform, ("XDG_STATE_HOME", ".local", "state"))
    chosen, home = os.environ.get(variable), home_folder()
    if not chosen and home is None:
        return None
    folder = Path(chosen) if chosen else Path(home or "", *usual)
    return folder / "ssdo_gl" / name


def kept(file: Path | None) -> Any:
    """Return what `keep` was given last; None if there is none, or it is somebody else's."""
    try:
        return None if file is None else json.loads(file.read_text(encoding="utf-8"))
    # RecursionError: brackets by the thousand.
    except (OSError, ValueError, RecursionError):
        return None


def keep(file: Path | None, value: Any) -> None:
    """Keep `value` for the next visit; where that is impossible, this one goes on without."""
    if file is None:
        return
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(file, (json.dumps(value, indent=1) + "\n").encode())
    except (OSError, OutputError):
        return


class Recent:
    """Paths of files opened last, the newest first.

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
