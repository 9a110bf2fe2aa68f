"""Passes events on to the panel, the divider or the input map, and keeps what they ask for."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial, update_wrapper
from typing import TYPE_CHECKING, Concatenate, ParamSpec, Protocol

import glfw

from ssdo_gl.window.actions import Host, perform
from ssdo_gl.window.input import Action, Command, InputMap
from ssdo_gl.window.viewer import Viewer
from ssdo_gl.window.views import divider_hit

if TYPE_CHECKING:
    from ssdo_gl.window.overlay import Overlay

PANEL_FRAMES = 3  # after an event: hover and layout take two to settle
_Event = ParamSpec("_Event")


class EventSource(Protocol):
    """Where events come from: a window, or a page."""

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in the coordinates of its events."""

    @property
    def content_scale(self) -> float:
        """By how much text must grow to keep its size."""


def _in_order(
    handle: Callable[Concatenate[Events, _Event], None],
) -> Callable[Concatenate[Events, _Event], None]:
    """Handle an event at once, but after what waits: it may be about what that leads to."""

    def take(self: Events, /, *event: _Event.args, **more: _Event.kwargs) -> None:
        if not self.pending:
            handle(self, *event, **more)
            return
        replay = partial(handle, self, *event, **more)
        self.pending.append(partial(self._input.as_of, self._input.now, replay))

    update_wrapper(take, handle)
    return take


class Events:
    """What has happened to a window since it was looked at last.

    Commands are kept, to be performed between two frames and in the order of their
    events, never from within an event: events also come while a frame is in the making.
    Those that follow a command are kept behind it.

    Attributes
    ----------
    pending : list of callable
        What was asked for.
    has_input : bool
        Whether there was anything that makes another picture.
    wants_release : bool
        Whether a long task shall be given up.
    panel_frames : int
        How often the panel has yet to be drawn.
    """

    def __init__(
        self,
        window: EventSource,
        viewer: Viewer,
        input_map: InputMap,
        host: Host,
        overlay: Overlay | None = None,
    ) -> None:
        self.pending: list[Callable[[], object]] = []
        self.has_input = self.wants_release = False
        self.panel_frames = PANEL_FRAMES
        self._unsettled_frames = 0
        self._window = window
        self._viewer = viewer
        self._input = input_map
        self._host = host
        self._overlay = overlay
        self._holds_divider = False

    @property
    def is_ready(self) -> bool:
        """Whether something waits that may be done between two frames."""
        return bool(self.pending) and not self._unsettled_frames

    def perform(self, *, waits: bool) -> None:
        """Do what was asked for.

        With `waits`, what follows a change of the panel is left until that was drawn.
        """
        queue, self.pending = self.pending, []
        try:
            while queue and not (waits and self._unsettled_frames):
                before = self._panel_shape
                queue.pop(0)()
                # What a kept event asks for comes before the events after it.
                queue[:0], self.pending = self.pending, []
                if self._panel_shape != before:
                    self.panel_frames = self._unsettled_frames = PANEL_FRAMES
        finally:
            self.pending = queue + self.pending

    def panel_drawn(self) -> None:
        """Note that the panel was drawn as it is."""
        self.panel_frames = max(0, self.panel_frames - 1)
        self._unsettled_frames = max(0, self._unsettled_frames - 1)

    @property
    def _panel_shape(self) -> object:
        return None if self._overlay is None else self._overlay.shape

    @_in_order
    def on_key(self, key: int, action: int, mods: int) -> None:
        """Hand a key to a text field, or to the input map."""
        self.panel_frames = PANEL_FRAMES
        if self._overlay is not None:
            self._overlay.key(key, action, mods)
            if self._overlay.wants_keyboard and action != glfw.RELEASE:
                return
        self._perform_later(self._input.key(key, action, mods))
        self.has_input |= self._input.is_holding

    @_in_order
    def on_character(self, code: int) -> None:
        """Hand a character to a text field."""
        if self._overlay is not None:
            self._overlay.character(code)

    @_in_order
    def on_button(self, button: int, action: int, place: tuple[float, float] | None = None) -> None:
        """Hand a mouse button to a widget, the divider, or the input map.

        With a `place` the cursor is there, wherever it was: a finger comes from nowhere.
        """
        self.panel_frames = PANEL_FRAMES
        if place is not None:
            self._input.cursor_jumped(*place)
        if self._overlay is not None:
            self._overlay.button(button, action)
            if self._overlay.wants_mouse and action == glfw.PRESS:
                return
        if button == glfw.MOUSE_BUTTON_LEFT:
            x, width = self._input.cursor_px[0], self._window.size[0]
            presses = action == glfw.PRESS
            self._holds_divider = presses and divider_hit(self._viewer.view, x, width)
        if not self._holds_divider:
            self._perform_later(self._input.button(button, action))

    @_in_order
    def on_cursor(self, x: float, y: float) -> None:
        """Hand the cursor to widgets, the divider and the input map."""
        self.panel_frames = PANEL_FRAMES
        self._input.cursor(x, y)
        self.has_input |= self._input.is_looking or self._input.is_dragging
        if self._overlay is not None:
            if self._input.is_looking:
                self._overlay.cursor_left()
            else:
                self._overlay.cursor(x, y)
        if self._holds_divider:
            share = x / max(1, self._window.size[0])
            self._viewer.view = self._viewer.view.with_divider(share)

    @_in_order
    def on_scroll(self, x: float, y: float) -> None:
        """Hand the wheel to the panel, or to the input map."""
        self.panel_frames = PANEL_FRAMES
        if self._overlay is not None:
            self._overlay.scroll(x, y)
            if self._overlay.wants_mouse:
                return
        self.has_input = True
        self._perform_later(self._input.scroll(y))

    @_in_order
    def on_focus(self, has_focus: bool) -> None:
        """Let go of everything when the keyboard goes to another window."""
        self.panel_frames = PANEL_FRAMES
        if not has_focus:
            self._input.focus_lost()
            self._holds_divider = False
        if self._overlay is not None:
            self._overlay.focus(has_focus)

    @_in_order
    def on_drop(self, paths: list[str]) -> None:
        """Open the first of the dropped files."""
        self.panel_frames = PANEL_FRAMES
        for path in paths[:1]:
            self._host.open(path)

    def on_change(self) -> None:
        """Draw again, for another size or scale."""
        self.panel_frames = PANEL_FRAMES
        self.has_input = True
        if self._overlay is not None:
            self._overlay.rescale(self._window.content_scale)

    def defer(self, act: Callable[[], object]) -> None:
        """Do something between two frames; the one in the making is given up."""
        self.has_input = True
        self.panel_frames = PANEL_FRAMES
        self.pending.append(act)

    def _perform_later(self, action: Action | None) -> None:
        if action is not None:
            self.defer(partial(perform, action, self._viewer, self._host))
            self.wants_release |= action.command == Command.RELEASE
