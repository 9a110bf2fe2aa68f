"""The session between a window and a viewer, with a fake window."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from pathlib import Path

import glfw
import numpy as np
import pytest

from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings
from ssdo_gl.window import session as session_module
from ssdo_gl.window.camera.controls import Controls
from ssdo_gl.window.glfw_window import GlfwWindow
from ssdo_gl.window.messages import Messages
from ssdo_gl.window.session import ANSWER_FRAMES, PATIENCE_MS, Session
from ssdo_gl.window.viewer import Viewer

pytest.importorskip("imgui_bundle")
SIZE = (48, 27)
FRAME_S = 1.0 / 30.0


class FakeWindow:
    cursor = (24.0, 16.0)
    content_scale = 1.0
    sizes = SIZE, SIZE
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
    monkeypatch.setattr(session_module.glfw, "poll_events", lambda: None)
    monkeypatch.setattr(Session, "_draw", lambda self, sizes, seconds: None)
    session = Session(FakeWindow(device), "carousel", viewer)  # type: ignore[arg-type]
    yield session
    session.release()


def press(session: Session, key: int) -> None:
    session.on_key(key, glfw.PRESS, 0)
    session.on_key(key, glfw.RELEASE, 0)


def rest(session: Session, viewer: Viewer) -> None:
    """Let frames pass until nothing is left to do."""
    if viewer.clock.is_running:
        viewer.clock.toggle()
    for _ in range(300):
        session._frame(FRAME_S)
        if not viewer.is_busy:
            return
    raise AssertionError("the picture does not come to rest")


@pytest.mark.parametrize("change", ["method", "size"])
@pytest.mark.parametrize("key", [glfw.KEY_F, glfw.KEY_W, glfw.KEY_I])
def test_key_that_reads_the_picture_may_interrupt_the_next_one(
    gl, session: Session, viewer: Viewer, monkeypatch: pytest.MonkeyPatch, change: str, key: int
) -> None:
    # Coarse in motion and fine at rest, so that there are frames to give up.
    viewer.budget_ms = 1e-3
    viewer.choose_method("ssao")
    rest(session, viewer)
    start = viewer.flight.position
    due = [True]

    def events() -> None:
        if due and viewer.is_resting:
            due.clear()
            press(session, key)

    monkeypatch.setattr(session_module.glfw, "poll_events", events)
    if change == "method":
        press(session, glfw.KEY_T)
    else:
        session._window.sizes = (64, 36), (64, 36)
        session.on_change()
    rest(session, viewer)
    assert not due, "nothing was interrupted"
    assert viewer.is_inspecting == (key == glfw.KEY_I)
    assert (viewer.flight.position == start) == (key == glfw.KEY_I)


def test_frame_uses_the_sizes_of_one_moment(gl, device, session: Session, viewer: Viewer) -> None:
    """A window that is dragged has another size every time it is asked."""
    window = GlfwWindow.__new__(GlfwWindow)
    sizes = iter([(40, 30), (80, 60), (80, 60), (80, 60), (80, 60), (80, 60)])
    GlfwWindow.size, kept = property(lambda self: next(sizes)), GlfwWindow.size
    GlfwWindow.pixels, kept_pixels = property(lambda self: next(sizes)), GlfwWindow.pixels
    try:
        assert window.sizes == ((80, 60), (80, 60))
    finally:
        GlfwWindow.size, GlfwWindow.pixels = kept, kept_pixels


def test_what_cannot_be_drawn_is_a_message_and_the_last_picture_stays(
    gl, session: Session, viewer: Viewer, capsys: pytest.CaptureFixture[str]
) -> None:
    rest(session, viewer)
    before = viewer.presenter.pixels()
    good = viewer.settings
    viewer.settings = dataclasses.replace(good, samples=10**6)
    nowhere = dataclasses.replace(viewer.flight, position=(1e300, 0.0, 0.0))
    viewer.flight = nowhere
    rest(session, viewer)
    assert viewer.settings == good
    assert any("cannot be drawn" in line.text for line in viewer.messages.lines)
    assert "cannot be drawn" in capsys.readouterr().err
    assert np.array_equal(viewer.presenter.pixels(), before)


def test_fault_of_the_program_itself_is_not_hidden(
    gl, session: Session, viewer: Viewer, monkeypatch: pytest.MonkeyPatch
) -> None:
    rest(session, viewer)

    def fail(*_: object) -> bool:
        raise RuntimeError("broken")

    monkeypatch.setattr(viewer, "frame", fail)
    session._frame(FRAME_S)
    with pytest.raises(RuntimeError, match="broken"):
        session._frame(FRAME_S)


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
