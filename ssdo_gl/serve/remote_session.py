"""A viewer without a window: takes events of a page, gives encoded pictures. Knows no network."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import glfw

from ssdo_gl.gpu.shader import ShaderError
from ssdo_gl.serve.delivery import Delivery, SentPicture
from ssdo_gl.serve.page_events import PageEventError, pixels_of
from ssdo_gl.serve.page_state import choose, flag, shown_state
from ssdo_gl.serve.remote_host import RemoteHost
from ssdo_gl.settings.fields import SettingError
from ssdo_gl.window.camera import Flight, jump_to, stilled
from ssdo_gl.window.events import Events
from ssdo_gl.window.film import Interrupted
from ssdo_gl.window.viewer import Viewer
from ssdo_gl.window.viewer_loop import AHEAD_SECONDS, ViewerLoop

_LETTERS = {f"Key{letter}": ord(letter) for letter in "ABCDEFGHIJKLMNOPQRSTUVWXYZ"}
_DIGITS = {f"Digit{digit}": ord(str(digit)) for digit in range(10)}
_FUNCTIONS = {f"F{i}": glfw.KEY_F1 + i - 1 for i in range(1, 13)}
_OTHERS = {
    "Space": glfw.KEY_SPACE,
    "Period": glfw.KEY_PERIOD,
    "Home": glfw.KEY_HOME,
    "Escape": glfw.KEY_ESCAPE,
    "Tab": glfw.KEY_TAB,
    "ArrowLeft": glfw.KEY_LEFT,
    "ArrowRight": glfw.KEY_RIGHT,
    "ArrowUp": glfw.KEY_UP,
    "ArrowDown": glfw.KEY_DOWN,
    "ShiftLeft": glfw.KEY_LEFT_SHIFT,
    "ShiftRight": glfw.KEY_RIGHT_SHIFT,
}
KEYS: dict[str, int] = {**_LETTERS, **_DIGITS, **_FUNCTIONS, **_OTHERS}
# ``MouseEvent.button`` counts from left to right.
BUTTONS = (glfw.MOUSE_BUTTON_LEFT, glfw.MOUSE_BUTTON_MIDDLE, glfw.MOUSE_BUTTON_RIGHT)


class RemoteSession(ViewerLoop):
    """A viewer whose events come from, and whose pictures go to, somewhere else.

    Everything is called in the thread that owns the viewer's context.

    Parameters
    ----------
    viewer : Viewer
        Belongs to the session from now on.
    size : (int, int)
        Of the picture until an event says another one.

    Attributes
    ----------
    size : (int, int)
        Of the page's picture in the coordinates of its events.
    pixels : (int, int)
        Of the picture.
    between_slices : callable
        Called every few milliseconds of a long frame, to hand over events; returns whether
        somebody else waits for the device.
    shares_camera : bool
        Whether the camera is to be where others have moved it, and theirs where this one is.

    Examples
    --------
    ::

        session = RemoteSession(viewer, (640, 360))
        session.handle(checked_event({"type": "key", "code": "KeyF", ...}))
        while session.is_due:
            picture = session.step()  # None: nothing to send
            ...
            session.handle(checked_event({"type": "ack", "frame": picture.number}))
    """

    content_scale = 1.0

    def __init__(
        self,
        viewer: Viewer,
        size: tuple[int, int],
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        super().__init__(viewer, self._event_clock)
        self.viewer = viewer
        self.size = self.pixels = size
        self.between_slices: Callable[[], bool] = lambda: False
        self.shares_camera = False
        self._clock = clock
        self._event_time: float | None = None
        self._woken_at: float | None = None
        self._host = RemoteHost(self._cursor_uv)
        self._events = Events(self, viewer, self._input, self._host)
        self._host.defer = self._events.defer
        self._delivery = Delivery(self._event_clock)
        self._stepped_at: float | None = None
        self._sent_count = 0
        self._sent_is_lossless = False

    # --- what comes ----------------------------------------------------------------

    def handle(self, event: Mapping[str, Any]) -> None:
        """Take an event as `page_events.checked_event` returns it.

        With ``at``, it came at that time of the clock: how far a key moves follows from when
        it went down and up, not from how long a frame took meanwhile.
        """
        self._event_time = event.get("at")
        had_input = self._events.has_input
        try:
            getattr(self, f"_on_{event['type']}")(event)
            if self._events.has_input and not had_input:
                self._woken_at = self._event_clock()
        finally:
            self._event_time = None

    def _event_clock(self) -> float:
        return self._clock() if self._event_time is None else self._event_time

    def _on_key(self, event: Mapping[str, Any]) -> None:
        key = KEYS.get(event["code"])
        if key is None:
            return
        action = glfw.RELEASE
        if event["down"]:
            action = glfw.REPEAT if event["repeat"] else glfw.PRESS
        self._events.on_key(key, action, event["mods"])

    def _on_button(self, event: Mapping[str, Any]) -> None:
        place = (event["x"], event["y"]) if event["down"] else None
        action = glfw.PRESS if event["down"] else glfw.RELEASE
        self._events.on_button(BUTTONS[event["button"]], action, place)

    def _on_cursor(self, event: Mapping[str, Any]) -> None:
        self._events.on_cursor(event["x"], event["y"])

    def _on_wheel(self, event: Mapping[str, Any]) -> None:
        self._events.on_scroll(0.0, event["notches"])

    def _on_focus(self, event: Mapping[str, Any]) -> None:
        self._events.on_focus(event["has"])

    def _on_size(self, event: Mapping[str, Any]) -> None:
        self.size = round(event["width"]), round(event["height"])
        self.pixels = pixels_of(event)
        self._events.on_change()

    def _on_ack(self, event: Mapping[str, Any]) -> None:
        self._delivery.acknowledge(event["frame"])

    def _on_choose(self, event: Mapping[str, Any]) -> None:
        self._events.defer(partial(self._choose, event["what"], event["value"]))

    def _choose(self, what: str, value: object) -> None:
        try:
            if what == "shared_camera":
                self.shares_camera = flag(value)
            else:
                choose(self.viewer, what, value)
        except (PageEventError, SettingError) as error:
            self.viewer.say(str(error), is_fault=True)

    def _cursor_uv(self) -> tuple[float, float]:
        (x, y), (width, height) = self._input.cursor_px, self.size
        return (0.5, 0.5) if self._input.is_looking else (x / width, y / height)

    # --- what goes -----------------------------------------------------------------

    @property
    def state(self) -> dict[str, Any]:
        """What the page shows around the picture."""
        self.viewer.messages.expire()
        own = {"looking": self._input.is_looking, "shared_camera": self.shares_camera}
        return {**shown_state(self.viewer), **own}

    def take_clipboard(self) -> str:
        """Return what the page shall put on its clipboard, once; empty if there is nothing."""
        text, self._host.clipboard = self._host.clipboard, ""
        return text

    @property
    def has_input(self) -> bool:
        """Whether somebody does something."""
        events = self._events
        return bool(events.pending) or events.has_input or self._input.is_holding

    @property
    def is_moving(self) -> bool:
        """Whether somebody waits for the answer to what they do, or what they follow moves."""
        return not self._is_broken and (self.has_input or not self.viewer.is_resting)

    @property
    def still_flight(self) -> Flight:
        """A flight at rest at the present camera, for others who share it."""
        viewer = self.viewer
        is_on_tour = viewer.tour.played_s is not None
        flight = jump_to(viewer.flight, viewer.camera) if is_on_tour else viewer.flight
        return stilled(flight)

    def follow(self, flight: Flight) -> None:
        """Go on from a flight of somebody else."""
        self.viewer.tour.stop()
        self.viewer.flight = flight
        self.viewer.touch()

    @property
    def is_due(self) -> bool:
        """Whether `step` has something to do.

        Not in motion while earlier pictures are on their way: what would be drawn would be
        old by the time that it may be sent.
        """
        if self._is_broken:
            return False
        if self._delivery.has_room:
            return self.viewer.is_busy or self.is_moving or self._is_unsent
        return self.viewer.is_busy and not self.is_moving

    @property
    def _is_unsent(self) -> bool:
        """Whether what is shown is not what was sent last, or that not lossless."""
        count = self.viewer.presenter.draw_count
        is_due = not self._sent_is_lossless and not self.viewer.is_busy
        return count > 0 and (count != self._sent_count or is_due)

    def perform(self) -> None:
        """Do what events have asked for, so that `state` has it before the next picture."""
        self._perform_pending(draws=True)

    def step(self) -> SentPicture | None:
        """Let time pass, draw what is due; return a picture if there is one to send."""
        now = self._clock()
        if self._stepped_at is not None:
            # Not before what was seen ahead.
            since, now = self._stepped_at, max(now, self._stepped_at)
        else:
            # What was slept through is no flight, but for what came since.
            since = now if self._woken_at is None else min(now, self._woken_at)
            now += AHEAD_SECONDS if self._events.has_input else 0.0
        self._woken_at = None
        self.perform()
        controls = self._input.take(since, now, self.size[1])
        self._events.has_input = self._events.wants_release = False
        self._render(controls, now - since, self.pixels)
        # The way of a camera that is followed is no edit, only where it ends.
        is_led = self.shares_camera and not self.viewer.is_resting
        if not (self._input.is_holding or self._input.is_dragging or is_led):
            self.viewer.note_edits()
        is_busy = self.viewer.is_busy or self._input.is_holding
        self._stepped_at = now if is_busy else None
        if not self._delivery.has_room or not self._is_unsent:
            return None
        self._sent_count = self.viewer.presenter.draw_count
        self._sent_is_lossless = not self.viewer.is_busy
        pixels = self.viewer.presenter.pixels()
        return self._delivery.pack(
            pixels, is_lossless=self._sent_is_lossless, is_resting=self.viewer.is_resting
        )

    def release(self) -> None:
        """Free everything on the device."""
        self.viewer.release()

    def _between_slices(self, what: str, done: int, total: int) -> None:
        others_wait = self.between_slices()
        wants_another = self._events.has_input or self.viewer.is_outdated(is_edited=False)
        if self.viewer.can_be_given_up and (wants_another or others_wait):
            raise Interrupted

    def _show_broken(self, error: ShaderError) -> None:
        self.viewer.say(str(error), is_fault=True)
        print(f"ssdo-gl: {error}", file=sys.stderr)
