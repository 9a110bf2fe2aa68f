"""The system's own dialog for opening a file, where there is one."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import Any

from ssdo_gl.scene.formats import model_suffixes, scene_suffixes

# What portable-file-dialogs runs on Linux, in its order.
_PROGRAMS = ("zenity", "matedialog", "qarma", "kdialog")


class FileDialog:
    """At most one dialog, which does not keep the window waiting."""

    def __init__(self) -> None:
        self._dialog: Any = None

    @staticmethod
    def exists() -> bool:
        """Whether this system has one."""
        if not sys.platform.startswith("linux"):
            return True
        return any(shutil.which(name) for name in _PROGRAMS)

    def show(self, folder: Path) -> None:
        """Ask for a file, beginning in `folder`."""
        if self._dialog is not None:
            return
        from imgui_bundle import portable_file_dialogs

        patterns = " ".join(f"*{suffix}" for suffix in (*scene_suffixes(), *model_suffixes()))
        filters = ["Scenes, models, presets", patterns, "All files", "*"]
        self._dialog = portable_file_dialogs.open_file("Open", str(folder), filters)

    def answer(self) -> str | None:
        """Return the path that was chosen, once; None if there is none (yet)."""
        if self._dialog is None or not self._dialog.ready(0):
            return None
        paths, self._dialog = self._dialog.result(), None
        return paths[0] if paths else None
