"""What a window keeps from one visit to the next: small files of JSON."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any

from ssdo_gl.images.files import OutputError, write_atomically
from ssdo_gl.process import home_folder


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
