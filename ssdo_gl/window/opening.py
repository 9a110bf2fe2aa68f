"""Opens models, scenes and presets in a viewer, and notices files that change.

What goes wrong becomes a message.
"""

from __future__ import annotations

import os
import shutil
import sys
import time
from pathlib import Path
from typing import Any

from ssdo_gl import resources
from ssdo_gl.gpu.shader import ShaderError, ShaderLibrary
from ssdo_gl.options.preset_files import is_preset
from ssdo_gl.scene.formats import model_suffixes, scene_suffixes
from ssdo_gl.scene.load import is_scene, load_scene
from ssdo_gl.scene.scene_error import SceneError
from ssdo_gl.settings.fields import SettingError
from ssdo_gl.window.camera import jump_to
from ssdo_gl.window.viewer import Viewer
from ssdo_gl.wording import counted

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


def open_file(path: str, viewer: Viewer) -> bool:
    """Show the model or scene in `path`; a bad one leaves the present scene.

    A preset is taken over instead, and gets a button in the panel. Returns whether
    there is another scene.
    """
    if is_preset(path):
        _open_preset(path, viewer)
        return False
    try:
        loading = viewer.original.loading
        if path != viewer.source:
            loading = loading.elsewhere(is_scene=is_scene(path))
        scene = load_scene(path, loading)
        viewer.open(scene, path)
    except (SceneError, SettingError) as error:
        viewer.say(str(error), is_fault=True)
        return False
    # A file of somebody else's must not take the window, and what is in it, along.
    except Exception as error:
        viewer.say(f"{path}: cannot be opened: {fault_text(error)}", is_fault=True)
        return False
    viewer.say(f"opened {Path(path).name}: {counted(scene.triangle_count, 'triangle')}")
    return True


def _open_preset(path: str, viewer: Viewer) -> None:
    if viewer.read_preset is None:
        return
    name = Path(path).stem
    try:
        viewer.add_preset(name, viewer.read_preset(path))
    except SettingError as error:
        viewer.say(f"{Path(path).name}: {error}", is_fault=True)
    except Exception as error:
        viewer.say(f"{path}: is no preset: {fault_text(error)}", is_fault=True)
    else:
        viewer.say(f"preset {name}")


def fault_text(error: Exception) -> str:
    """Return what went wrong in one line, whatever it was."""
    return " ".join(str(error).split()) or type(error).__name__


def reload_file(viewer: Viewer) -> None:
    """Read the scene again: from where one stands, unless its own camera is another."""
    camera, seconds = viewer.camera, viewer.clock.seconds
    has_own = camera == viewer.loaded.camera
    if open_file(viewer.source, viewer):
        viewer.clock.seconds = seconds
        if not has_own:
            viewer.flight = jump_to(viewer.flight, camera)


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
