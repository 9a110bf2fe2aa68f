"""Viewers without a window."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from window.driven_viewer import SETTINGS

from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings
from ssdo_gl.window.viewer import Viewer


@pytest.fixture
def make_viewer(device: Device, shaders: ShaderLibrary, tmp_path: Path):
    """Make viewers that are released at the end."""
    made = []

    def make(source: str = "cornell_meso", settings: Settings = SETTINGS, **loading: Any) -> Viewer:
        viewer = Viewer(
            device,
            load_scene(source, **loading),
            settings,
            source=source,
            folder=tmp_path,
            shaders=shaders,
        )
        made.append(viewer)
        return viewer

    yield make
    for viewer in made:
        viewer.release()


@pytest.fixture
def viewer(make_viewer) -> Viewer:
    return make_viewer()


@pytest.fixture
def drawn(device: Device, shaders: ShaderLibrary, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """A `DrawnOverlay` of the built-in room."""
    from window.overlay.drawn_overlay import DrawnOverlay

    from ssdo_gl.window.panel import panel as panel_module

    # The only number of a picture at rest that changes by itself.
    monkeypatch.setattr(panel_module, "memory_mb", lambda: 100.0)
    drawn = DrawnOverlay(device, shaders, "cornell_meso", tmp_path)
    yield drawn
    drawn.release()
