"""The session between a window and a viewer, with a fake window."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Iterator
from pathlib import Path

import glfw
import numpy as np
import pytest
from window.driven_viewer import Clock

from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings
from ssdo_gl.window import session as session_module
from ssdo_gl.window.camera.controls import Controls
from ssdo_gl.window.film import Interrupted
from ssdo_gl.window.glfw_window import GlfwWindow
from ssdo_gl.window.input import Command
from ssdo_gl.window.messages import Messages
from ssdo_gl.window.session import Session
from ssdo_gl.window.viewer import Viewer

pytest.importorskip("imgui_bundle")
from window.overlay.drawn_overlay import skip_without_panel

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

    def toggle_fullscreen(self) -> None: ...

    def ask_to_close(self) -> None: ...


@pytest.fixture
def viewer(device: Device, shaders: ShaderLibrary, tmp_path: Path) -> Viewer:
    return Viewer(
        device,
        load_scene("carousel"),
        Settings("bounce", samples=8, steps=4),
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
    monkeypatch.setattr(Session, "_draw", lambda self, sizes: None)
    skip_without_panel(device)
    session = Session(FakeWindow(device), "carousel", viewer)  # type: ignore[arg-type]
    yield session
    session.release()


def pass_time(session: Session) -> None:
    now = time.perf_counter()
    session._frame(now - FRAME_S, now)


def press(session: Session, key: int) -> None:
    session._events.on_key(key, glfw.PRESS, 0)
    session._events.on_key(key, glfw.RELEASE, 0)


def rest(session: Session, viewer: Viewer) -> None:
    """Let frames pass until nothing is left to do."""
    if viewer.clock.is_running:
        viewer.clock.toggle()
    for _ in range(300):
        pass_time(session)
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
        session._events.on_change()
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
    viewer.settings = dataclasses.replace(good)
    object.__setattr__(viewer.settings, "samples", 10**6)
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
    pass_time(session)
    with pytest.raises(RuntimeError, match="broken"):
        pass_time(session)


def test_lines_go_while_pictures_follow_one_another(session: Session, viewer: Viewer) -> None:
    clock = Clock()
    viewer.messages = Messages(clock)
    viewer.say("hello")
    pass_time(session)
    assert viewer.messages.lines
    clock.seconds = 60.0
    drawing = viewer.left.image.drawing
    pass_time(session)
    assert viewer.left.image.drawing is not drawing, "the scene does not move"
    assert not viewer.messages.lines


@pytest.fixture
def in_the_making(session: Session, viewer: Viewer, monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """A frame at rest is in the making; the list counts how often the panel is drawn."""
    rest(session, viewer)
    assert viewer.can_be_given_up
    drawn: list[int] = []
    monkeypatch.setattr(session, "_draw", lambda sizes: drawn.append(1))
    session._events.panel_frames = 0
    session._drawn_at = 0.0
    return drawn


def is_given_up(session: Session) -> bool:
    try:
        session._between_slices("pass", 0, 0)
    except Interrupted:
        return True
    return False


def test_the_panel_answers_between_the_slices_of_a_frame(
    session: Session, in_the_making: list[int]
) -> None:
    assert not is_given_up(session)
    assert not in_the_making, "nothing has happened"
    session._events.on_cursor(5.0, 5.0)
    assert not is_given_up(session)
    assert in_the_making


@pytest.mark.parametrize(
    ("key", "gives_up"),
    [(glfw.KEY_W, True), (glfw.KEY_T, True), (glfw.KEY_LEFT_SHIFT, False), (glfw.KEY_J, False)],
)
def test_only_keys_that_mean_something_give_a_frame_up(
    session: Session, in_the_making: list[int], key: int, gives_up: bool
) -> None:
    session._events.on_key(key, glfw.PRESS, 0)
    assert is_given_up(session) == gives_up


def test_a_dragged_setting_is_drawn_before_the_next_one(
    session: Session, viewer: Viewer, in_the_making: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    drags = [True]
    monkeypatch.setattr(type(session._host.overlay), "is_busy", property(lambda self: drags[0]))
    viewer.settings = dataclasses.replace(viewer.settings, samples=16)
    assert not is_given_up(session)
    drags[0] = False
    assert is_given_up(session)


def test_a_setting_is_looked_at_in_full_size(session: Session, viewer: Viewer) -> None:
    viewer.budget_ms = 1e-3
    rest(session, viewer)
    for samples in (16, 24):
        viewer.settings = dataclasses.replace(viewer.settings, samples=samples)
        pass_time(session)
        assert viewer.left.image.drawing.view.size == SIZE
        assert viewer.left.image.renderer.settings.samples == samples
    session._events.on_key(glfw.KEY_W, glfw.PRESS, 0)
    # The last picture, as it is seen from farther on, and then one of its own.
    for _ in range(2):
        pass_time(session)
    assert viewer.left.image.drawing.view.size < SIZE


def test_the_divider_follows_while_a_frame_is_in_the_making(
    session: Session, viewer: Viewer, in_the_making: list[int]
) -> None:
    viewer.view = dataclasses.replace(viewer.view, is_split=True, other_method="direct")
    rest(session, viewer)
    before = viewer.presenter.pixels()
    viewer.view = viewer.view.with_divider(0.2)
    session._events.panel_frames = 1
    session._drawn_at = 0.0
    assert not is_given_up(session)
    assert not np.array_equal(viewer.presenter.pixels(), before)


def test_a_button_is_about_what_the_key_before_it_has_brought(
    session: Session, viewer: Viewer
) -> None:
    events, middle = session._events, SIZE[0] / 2
    rest(session, viewer)
    pivot = viewer.flight.pivot
    events.on_cursor(middle, 16.0)
    press(session, glfw.KEY_V)
    events.on_button(glfw.MOUSE_BUTTON_LEFT, glfw.PRESS)
    events.on_cursor(SIZE[0] / 4, 16.0)
    events.on_button(glfw.MOUSE_BUTTON_LEFT, glfw.RELEASE)
    events.on_cursor(middle, 16.0)
    pass_time(session)
    assert viewer.view.divider == pytest.approx(0.25), "the divider is where it was let go"
    assert viewer.flight.pivot == pivot, "the camera heard of the button, too"


def test_what_is_typed_after_a_question_is_its_answer(
    session: Session, viewer: Viewer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.undo()
    monkeypatch.setattr(session_module, "gamepad", Controls)
    overlay, events = session._host.overlay, session._events
    size = 640, 400  # room for the question
    target = viewer.device.gl.simple_framebuffer(size, 4)

    def draw(_: object) -> None:
        events.panel_drawn()
        overlay.compose(target, size, size, FRAME_S)

    monkeypatch.setattr(session, "_draw", draw)
    monkeypatch.setattr(session_module.glfw, "poll_events", lambda: None)
    session._host.commands[Command.OPEN] = overlay.path_prompt.show
    rest(session, viewer)
    start, method = viewer.flight.position, viewer.view.method
    events.on_key(glfw.KEY_O, glfw.PRESS, glfw.MOD_CONTROL)
    for key, character in ((glfw.KEY_W, "w"), (glfw.KEY_T, "t")):
        events.on_key(key, glfw.PRESS, 0)
        events.on_character(ord(character))
        events.on_key(key, glfw.RELEASE, 0)
    for _ in range(12):
        pass_time(session)
    assert not events.pending
    assert overlay.path_prompt._text == "wt"
    assert (viewer.flight.position, viewer.view.method) == (start, method)
    target.release()


def test_the_cursor_is_let_go_while_a_frame_is_in_the_making(
    session: Session, in_the_making: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    hidden: list[bool] = []
    monkeypatch.setattr(session._window, "hide_cursor", lambda hides: hidden.append(hides))
    session._events.on_button(glfw.MOUSE_BUTTON_RIGHT, glfw.PRESS)
    is_given_up(session)
    session._events.on_button(glfw.MOUSE_BUTTON_RIGHT, glfw.RELEASE)
    is_given_up(session)
    assert hidden == [True, False]
