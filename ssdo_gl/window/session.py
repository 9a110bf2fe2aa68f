"""A viewer in a window: looks for events, lets the viewer draw, shows it with the panel."""

from __future__ import annotations

import statistics
import sys
import time
from collections import deque

import glfw

from ssdo_gl.gpu.shader import ShaderError
from ssdo_gl.window.events import PANEL_FRAMES, Events
from ssdo_gl.window.film import FilmExport, Interrupted
from ssdo_gl.window.glfw_window import GlfwWindow, gamepad, has_gamepad
from ssdo_gl.window.host import NO_PANEL, WindowHost
from ssdo_gl.window.input import combined
from ssdo_gl.window.kept_files import usual_file
from ssdo_gl.window.opening import ShaderWatch, shader_folder
from ssdo_gl.window.viewer import Viewer
from ssdo_gl.window.viewer_loop import AHEAD_SECONDS, ViewerLoop

# How long to sleep when there is nothing to do. Files are looked at as often.
IDLE_SECONDS = 0.5
GAMEPAD_SECONDS = 1.0 / 60.0
# How often the panel is drawn while a frame is in the making, at most, and for which part
# of the time: it has to be answered, and the frame to be finished.
BEAT_SECONDS = 1.0 / 60.0
BEAT_SHARE = 0.4
# How many frames tell how long it takes to show one.
SHOWN_FRAMES = 9
# What is on the screen follows events at least so soon, whatever is given up meanwhile.
LATEST_SECONDS = 0.2
_HINT = "drag: orbit   wheel: closer   right drag: look   WASD: fly   F1: all keys   Tab: panel"


class Session(ViewerLoop):
    """A viewer in a window."""

    def __init__(self, window: GlfwWindow, title: str, viewer: Viewer) -> None:
        super().__init__(viewer)
        self._window = window
        self._input.cursor_jumped(*window.cursor)
        self._shader_watch = ShaderWatch(self._viewer.shaders, shader_folder())
        self._film = FilmExport(self._viewer)
        self._gave_up = False
        self._waits_since = 0.0
        self._showing_ms: deque[float] = deque(maxlen=SHOWN_FRAMES)
        self._drawn_at = self._draw_seconds = 0.0
        self._host = WindowHost(window, viewer, self._input, self._film, title)
        self._host.reload = self._reload_shaders
        self._make_overlay()
        viewer.stretches = True
        self._events = Events(window, viewer, self._input, self._host, self._host.overlay)
        self._host.defer = self._events.defer
        window.listen(self._events)

    def _make_overlay(self) -> None:
        try:
            from ssdo_gl.window.overlay import Overlay
        except ImportError:
            self._viewer.say(NO_PANEL)
            print(f"ssdo-gl: {NO_PANEL}", file=sys.stderr)
            return
        scale, width = self._window.content_scale, self._window.size[0]
        looks = usual_file("looks.json")
        self._host.overlay = Overlay(self._viewer, self._host, scale, width, looks)
        self._viewer.say(_HINT)

    def run(self) -> None:
        """Answer events and draw until the window is closed."""
        self._viewer.say("compiling shaders")
        for _ in range(PANEL_FRAMES):
            self._draw(self._window.sizes)
        last = time.perf_counter()
        while not self._window.should_close:
            if self._is_busy():
                glfw.poll_events()
                now = max(last, time.perf_counter() + self._gave_up * AHEAD_SECONDS)
            else:
                glfw.wait_events_timeout(GAMEPAD_SECONDS if has_gamepad() else IDLE_SECONDS)
                # What was slept through was no flight.
                last = time.perf_counter()
                now = last + AHEAD_SECONDS if self._events.has_input else last
            self._frame(last, now)
            last = now

    def release(self) -> None:
        """Free everything on the device."""
        self._film.give_up()
        self._host.release()
        if self._host.overlay is not None:
            self._host.overlay.release()
        self._viewer.release()

    # --- one frame -----------------------------------------------------------------

    def _is_busy(self) -> bool:
        if min(self._window.pixels) < 1:
            return bool(self._events.pending)
        return bool(
            (self._viewer.is_busy and not self._is_broken)
            or self._events.pending
            or self._events.panel_frames > 0
            or self._input.is_holding
            or self._film.is_busy
            or self._is_edited_now
        )

    @property
    def _is_edited_now(self) -> bool:
        """Whether somebody is dragging a control."""
        return self._host.overlay is not None and self._host.overlay.is_busy

    def _frame(self, since: float, now: float) -> None:
        """Let the time between two moments pass, and draw what is due."""
        sizes = self._window.sizes
        size = sizes[1]
        gave_up_before, self._gave_up = self._gave_up, False
        self._perform_pending(draws=min(size) > 0 and not self._film.is_busy)
        if self._host.look_at_files():
            self._events.panel_frames = PANEL_FRAMES
        self._hide_cursor()
        controls = self._input.take(since, now, sizes[0][1])
        self._events.has_input = self._events.wants_release = False
        if self._shader_watch.poll():
            self._after_reload()
        if self._film.is_busy:
            drew = self._film.step(self._interrupt_film)
        else:
            drew = self._render(combined(controls, gamepad()), now - since, size)
        if not (self._is_edited_now or self._input.is_holding or self._input.is_dragging):
            self._viewer.note_edits()
        # Before `drew` is looked at: lines go while pictures follow one another, too.
        if self._viewer.messages.expire() or drew:
            drew = True
            # Text that has changed its length takes another frame to fit its window.
            self._events.panel_frames = max(self._events.panel_frames, 2)
        # The picture for which one was given up comes first, and brings the panel along.
        ended = time.perf_counter()
        if not (self._gave_up and gave_up_before) or ended - now > LATEST_SECONDS:
            self._waits_since = ended
        waits = self._gave_up and ended - self._waits_since < LATEST_SECONDS
        if min(size) > 0 and not waits and (drew or self._events.panel_frames > 0):
            self._draw(sizes)

    def _draw(self, sizes: tuple[tuple[int, int], tuple[int, int]]) -> None:
        """Show the picture, and the panel over it, in a window as `GlfwWindow.sizes` has it."""
        now = time.perf_counter()
        seconds, self._drawn_at = now - self._drawn_at, now
        self._events.panel_drawn()
        screen = self._window.device.gl.screen
        if self._viewer.presenter.picture is not None:
            self._viewer.presenter.copy_to(screen, sizes[1])
        if self._host.overlay is not None:
            self._host.overlay.compose(screen, *sizes, min(seconds, IDLE_SECONDS))
        else:
            self._say_in_title()
        self._window.swap()
        self._draw_seconds = time.perf_counter() - now
        if self._window.device.is_software:
            # Elsewhere the time is that of a display that is waited for.
            self._showing_ms.append(1e3 * self._draw_seconds)
            self._viewer.showing_ms = statistics.median(self._showing_ms)

    def _say_in_title(self) -> None:
        """Without a panel the title is where there is room for a line."""
        viewer = self._viewer
        said = [line.text for line in viewer.messages.lines]
        said = said or [f"{viewer.view.method} {viewer.view.aov}"]
        self._window.set_title(f"{self._host.title} - {said[-1]}")

    # --- while a frame is in the making --------------------------------------------

    def _between_slices(self, what: str, done: int, total: int) -> None:
        """Hear of events, give the frame up for a better one; else let the panel answer."""
        glfw.poll_events()
        self._hide_cursor()
        is_outdated = self._viewer.is_outdated(is_edited=self._is_edited_now)
        wants_another = self._events.has_input or self._events.is_ready or is_outdated
        if self._window.should_close or (self._viewer.can_be_given_up and wants_another):
            self._gave_up = True
            raise Interrupted
        self._beat()

    def _hide_cursor(self) -> None:
        """Hide and hold the cursor while it looks around, and let it go as soon as that ends."""
        if self._window.hide_cursor(self._input.is_looking):
            self._input.cursor_jumped(*self._window.cursor)

    def _beat(self) -> None:
        """Draw the panel over the picture as it is, if it has heard of anything."""
        beat = max(BEAT_SECONDS, self._draw_seconds / BEAT_SHARE)
        is_due = time.perf_counter() - self._drawn_at >= beat
        if self._events.panel_frames < 1 or not is_due:
            return
        sizes = self._window.sizes
        if min(sizes[1]) > 0 and self._viewer.presenter.picture is not None:
            self._viewer.present_again(sizes[1])
            self._draw(sizes)

    def _interrupt_film(self, what: str, done: int, total: int) -> None:
        glfw.poll_events()
        if self._events.wants_release or self._window.should_close:
            raise Interrupted

    # --- shaders -------------------------------------------------------------------

    def _show_broken(self, error: ShaderError) -> None:
        self._show_faults((*self._shader_watch.faults, str(error)))

    def _reload_shaders(self) -> None:
        self._shader_watch.reload()
        self._after_reload()

    def _after_reload(self) -> None:
        self._is_broken = False
        self._viewer.restart()
        self._show_faults(self._shader_watch.faults)
        if not self._shader_watch.faults:
            self._viewer.say("shaders are up to date")

    def _show_faults(self, faults: tuple[str, ...]) -> None:
        self._events.panel_frames = PANEL_FRAMES
        if self._host.overlay is not None:
            self._host.overlay.show_faults(faults)
        for fault in faults:
            print(f"ssdo-gl: {fault}", file=sys.stderr)
