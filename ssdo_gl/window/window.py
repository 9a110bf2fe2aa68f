"""Opens the interactive window."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.window.glfw_window import GlfwWindow
from ssdo_gl.window.session import Session
from ssdo_gl.window.viewer import Viewer


def open_window(scene: Scene, settings: Settings, *, source: str = "", **options: Any) -> None:
    """Show `scene` in a window until it is closed.

    Parameters
    ----------
    settings : Settings
        ``size`` is that of the window, in its own coordinates.
    source : str
        The scene as the user named it.
    options
        Others of `Viewer`.

    Raises
    ------
    ContextError
        If there is no display or no OpenGL for a window.
    """
    title = f"{Path(source).name or scene.title} - ssdo_gl"
    window = GlfwWindow(settings.size, title)
    try:
        viewer = Viewer(window.device, scene, settings, source=source, **options)
        session = Session(window, title, viewer)
        try:
            session.run()
        finally:
            session.release()
    finally:
        window.close()
