"""The session between a window and a viewer, with a window that only pretends."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import glfw
import pytest

from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings
from ssdo_gl.window import session as session_module
from ssdo_gl.window.controls import Controls
from ssdo_gl.window.messages import Messages
from ssdo_gl.window.session import ANSWER_FRAMES, PATIENCE_MS, Session
from ssdo_gl.window.viewer import Viewer

pytest.importorskip("imgui_bundle")
SIZE = (48, 27)
FRAME_S = 1.0 / 30.0


class PretendedWindow:
    cursor = (0.0, 0.0)
    content_scale = 1.0
    size = pixels = SIZE
    should_close = False

    def __init__(self, device: Device) -> None:
        self.device = device

    def listen(self, listener: object) -> None: ...

    def hide_cursor(self, hides: bool) -> bool:
        return False


class Clock:
    seconds = 0.0

    def __call__(self) -> float:
        return self.seconds


@pytest.fixture
def viewer(device: Device, shaders: ShaderLibrary, tmp_path: Path) -> Viewer:
    return Viewer(
        device,
        load_scene("carousel"),
        Settings(samples=8, steps=4),
        source="carousel",
        folder=tmp_path,
        shaders=shaders,
    )


@pytest.fixture
def session(
    gl, device: Device, viewer: Viewer, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Session]:
    monkeypatch.setattr(session_module, "gamepad", Controls)
    monkeypatch.setattr(Session, "_draw", lambda self, size, seconds: None)
    session = Session(PretendedWindow(device), "carousel", viewer)  # type: ignore[arg-type]
    yield session
    session.release()


def test_lines_go_while_pictures_follow_one_another(session: Session, viewer: Viewer) -> None:
    clock = Clock()
    viewer.messages = Messages(clock)
    viewer.say("hello")
    session._frame(FRAME_S)
    assert viewer.messages.lines
    clock.seconds = 60.0
    drawing = viewer.left.image.drawing
    session._frame(FRAME_S)
    assert viewer.left.image.drawing is not drawing, "the scene does not move"
    assert not viewer.messages.lines


def test_a_click_on_the_panel_is_answered_before_the_next_slow_picture(
    session: Session, viewer: Viewer, monkeypatch: pytest.MonkeyPatch
) -> None:
    viewer.clock.toggle()
    for _ in range(40):
        session._frame(FRAME_S)
        if viewer.is_resting:
            break
    drawn: list[float] = []

    def slow(*_: object) -> bool:
        drawn.append(1.0)
        viewer.frame_ms = 2.0 * PATIENCE_MS
        return True

    monkeypatch.setattr(viewer, "frame", slow)
    monkeypatch.setattr(type(session._overlay), "wants_mouse", True)
    session._frame(FRAME_S)
    session.on_button(glfw.MOUSE_BUTTON_LEFT, glfw.PRESS)
    del drawn[:]
    for _ in range(ANSWER_FRAMES):
        session._frame(FRAME_S)
    assert not drawn
    session._frame(FRAME_S)
    assert drawn, "the picture does not go on"
