"""Opens the interactive window."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.window.canvas import DEFAULT_BUDGET_MS
from ssdo_gl.window.glfw_window import GlfwWindow
from ssdo_gl.window.session import Session
from ssdo_gl.window.viewer import Viewer


def make_viewer(
    device: Device,
    scene: Scene,
    settings: Settings,
    *,
    aov: str = "beauty",
    seconds: float = 0.0,
    read_preset: Callable[[str], Mapping[str, Any]] | None = None,
    shaders: ShaderLibrary | None = None,
    **options: Any,
) -> Viewer:
    """Return a viewer of `scene`; parameters as of `open_window`, `options` of `Viewer`."""
    viewer = Viewer(device, scene, settings, shaders=shaders, **options)
    viewer.read_preset = read_preset
    viewer.view = dataclasses.replace(viewer.view, aov=aov)
    viewer.clock.seconds = seconds
    return viewer


def open_window(
    scene: Scene,
    settings: Settings,
    *,
    camera: Camera | None = None,
    source: str = "",
    budget_ms: float | None = DEFAULT_BUDGET_MS,
    presets: Mapping[str, Mapping[str, Any]] = MappingProxyType({}),
    measured: Sequence[Mapping[str, Any]] = (),
    read_preset: Callable[[str], Mapping[str, Any]] | None = None,
    aov: str = "beauty",
    seconds: float = 0.0,
) -> None:
    """Show `scene` in a window until it is closed.

    Parameters
    ----------
    settings : Settings
        ``size`` is that of the window, in its own coordinates.
    camera : Camera or None
        Where the flight begins; None: the scene's.
    source : str
        The scene as the user named it.
    budget_ms : float or None
        What a frame may take while something moves; None: whatever it needs.
    presets : mapping of name to fields of Settings
    measured : sequence of mapping
        Settings that were found best for their time, from fast to accurate: what the
        budget is held with.
    read_preset : callable or None
        Returns the fields of Settings in a file that is dropped on the window; raises
        SettingError.
    aov : str
        The image that is shown first.
    seconds : float
        Time of an animated scene at the beginning.

    Raises
    ------
    ContextError
        If there is no display or no OpenGL for a window.
    """
    title = f"{Path(source).name or scene.title} - ssdo_gl"
    window = GlfwWindow(settings.size, title)
    try:
        viewer = make_viewer(
            window.device,
            scene,
            settings,
            aov=aov,
            seconds=seconds,
            read_preset=read_preset,
            source=source,
            camera=camera,
            budget_ms=budget_ms,
            presets=presets,
            measured=measured,
        )
        session = Session(window, title, viewer)
        try:
            session.run()
        finally:
            session.release()
    finally:
        window.close()
