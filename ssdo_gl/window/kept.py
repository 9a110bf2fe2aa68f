"""What a window keeps from one visit to the next: small files of JSON."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any

from ssdo_gl.images.files import OutputError, write_atomically


def usual_file(name: str) -> Path:
    """Return where the system wants such a thing to be kept."""
    home = Path.home()
    if sys.platform == "win32":
        folder = Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local")
    elif sys.platform == "darwin":
        folder = home / "Library" / "Application Support"
    else:
        folder = Path(os.environ.get("XDG_STATE_HOME") or home / ".local" / "state")
    return folder / "ssdo_gl" / name


def kept(file: Path) -> Any:
    """Return what `keep` was given last; None if there is none, or it is somebody else's."""
    try:
        return json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None


def keep(file: Path, value: Any) -> None:
    """Keep `value` for the next visit; where that is impossible, this one goes on without."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(file, (json.dumps(value, indent=1) + "\n").encode())
    except (OSError, OutputError):
        return
