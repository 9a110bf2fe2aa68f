"""A viewer with its overlay, drawn and clicked without a window."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import glfw
import moderngl
import numpy as np
import pytest
from window.driven_viewer import FakeHost

from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.gpu.texture import make_framebuffer, make_texture
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings
from ssdo_gl.window.camera.controls import Controls
from ssdo_gl.window.kept_files import Recent
from ssdo_gl.window.viewer import Viewer

pytest.importorskip("imgui_bundle")
from ssdo_gl.window.overlay.overlay import Overlay
from ssdo_gl.window.saving.picture_job import PictureRequest

SIZE = (900, 700)
PICTURE = (36, 28)


class OverlayHost(FakeHost):
    """One that does at once what widgets put off, and remembers files."""

    def __init__(self) -> None:
        super().__init__()
        self.recent = Recent(Path("/nonexistent"))
        self.opened: list[str] = []
        self.requested: PictureRequest | None = None

    def defer(self, act: Callable[[], object]) -> None:
        act()

    def open(self, path: str) -> None:
        self.opened.append(path)

    def save_picture(self, request: PictureRequest) -> None:
        self.requested = request


def skip_without_panel(device: Device) -> None:
    """Skip where Dear ImGui finds no OpenGL: it looks for that of windows, which EGL has, too."""
    if device.backend == "osmesa":
        pytest.skip("no panel is drawn with OSMesa")


class DrawnOverlay:
    """A viewer with its overlay, and a framebuffer for a screen."""

    def __init__(self, device: Device, shaders: ShaderLibrary, scene: str, folder: Path) -> None:
        skip_without_panel(device)
        self.viewer = Viewer(
            device,
            load_scene(scene),
            Settings("bounce", samples=8, steps=4),
            source=scene,
            folder=folder,
            shaders=shaders,
        )
        self.overlay = Overlay(self.viewer, OverlayHost())
        self.texture = make_texture(device.gl, SIZE, 4, "nu1")
        self.screen: moderngl.Framebuffer = make_framebuffer(device.gl, [self.texture])

    def frames(self, count: int = 3) -> np.ndarray:
        """Let frames pass; return the screen, (height, width, 3), row 0 at the top."""
        for _ in range(count):
            self.viewer.frame(Controls(), 0.05, PICTURE)
            self.screen.clear()
            self.viewer.presenter.copy_to(self.screen, SIZE)
            self.overlay.compose(self.screen, SIZE, SIZE, 0.05)
        data = np.frombuffer(self.screen.read(components=3, alignment=1), np.uint8)
        return data.reshape(SIZE[1], SIZE[0], 3)[::-1].astype(int)

    def settled(self) -> np.ndarray:
        """Return the screen once the picture behind the panel stands still."""
        for _ in range(100):
            if not self.viewer.is_busy:
                break
            self.viewer.frame(Controls(), 0.05, PICTURE)
        self.viewer.messages.lines.clear()
        return self.frames(4)

    def click(self, x: float, y: float) -> None:
        self.overlay.cursor(x, y)
        self.frames(2)
        self.overlay.button(glfw.MOUSE_BUTTON_LEFT, glfw.PRESS)
        self.frames(2)
        self.overlay.button(glfw.MOUSE_BUTTON_LEFT, glfw.RELEASE)
        self.frames(2)

    def release(self) -> None:
        self.overlay.release()
        self.viewer.release()
        self.screen.release()
        self.texture.release()
