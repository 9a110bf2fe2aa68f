"""Opens models, scenes and presets in a viewer; what goes wrong becomes a message."""

from __future__ import annotations

from pathlib import Path

from ssdo_gl.options.preset_files import is_preset
from ssdo_gl.scene.load import is_scene, load_scene
from ssdo_gl.scene.scene_error import SceneError
from ssdo_gl.settings.fields import SettingError
from ssdo_gl.window.camera import jump_to
from ssdo_gl.window.viewer import Viewer
from ssdo_gl.wording import counted


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
