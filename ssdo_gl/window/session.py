"""A viewer in a window: events in, the viewer's picture and the panel out."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import glfw

from ssdo_gl.gpu.shader import ShaderError
from ssdo_gl.window.actions import fault_text, open_file, perform
from ssdo_gl.window.camera import Controls
from ssdo_gl.window.divider import DividerGrip
from ssdo_gl.window.film import FilmExport, Interrupted
from ssdo_gl.window.glfw_window import GlfwWindow, gamepad, has_gamepad
from ssdo_gl.window.hot_reload import ShaderWatch, shader_folder
from ssdo_gl.window.input_map import Action, Command, InputMap, combined
from ssdo_gl.window.viewer import Viewer

if TYPE_CHECKING:
    from ssdo_gl.window.overlay import Overlay

# How long to sleep when there is nothing to do. Shader files are looked at as often.
IDLE_SECONDS = 0.5
GAMEPAD_SECONDS = 1.0 / 60.0
PANEL_FRAMES = 3  # after an event: hover and layout take two to settle
# How often the panel is drawn while a frame is in the making, at most.
BEAT_SECONDS = 1.0 / 60.0
_NO_PANEL = "there is no panel without imgui-bundle: pip install 'ssdo_gl[window]'"


class Session:
    """A viewer in a window: hears of events, performs what they ask for, draws.

    Commands are performed between two frames and in the order of their events, never
    from within an event: events also come while a long pass is looked after.
    """

    def __init__(self, window: GlfwWindow, title: str, viewer: Viewer) -> None:
        self._window = window
        self._title = title
        self._viewer = viewer
        self._input = InputMap()
        self._input.cursor_jumped(*window.cursor)
        self._pending: list[Callable[[], object]] = []
        self._shader_watch = ShaderWatch(self._viewer.shaders, shader_folder())
        self._film = FilmExport(self._viewer)
        self._is_broken = False
        self._divider = DividerGrip(viewer)
        self._has_input = self._wants_release = False
        self._waits = True
        self._panel_frames = PANEL_FRAMES
        self._drawn_at = 0.0
        self._overlay: Overlay | None = None
        self._make_overlay()
        window.listen(self)

    def _make_overlay(self) -> None:
        try:
            from ssdo_gl.window.overlay import Overlay
        except ImportError:
            self._viewer.say(_NO_PANEL)
            print(f"ssdo-gl: {_NO_PANEL}", file=sys.stderr)
            return
        scale, width = self._window.content_scale, self._window.size[0]
        self._overlay = Overlay(self._window.device, self._viewer, self, scale, width)
        self._viewer.say("Tab: panel   F1: keys")

    def run(self) -> None:
        """Answer events and draw until the window is closed."""
        self._viewer.say("compiling shaders")
        for _ in range(PANEL_FRAMES):
            self._draw(self._window.sizes, 1.0 / 60.0)
        last = time.perf_counter()
        while not self._window.should_close:
            if self._is_busy():
                glfw.poll_events()
            else:
                glfw.wait_events_timeout(GAMEPAD_SECONDS if has_gamepad() else IDLE_SECONDS)
                # What was slept through was no flight.
                last = time.perf_counter()
            now = time.perf_counter()
            self._frame(now - last)
            last = now

    def release(self) -> None:
        """Free everything on the device."""
        self._film.give_up()
        if self._overlay is not None:
            self._overlay.release()
        self._viewer.release()

    # --- one frame -----------------------------------------------------------------

    def _is_busy(self) -> bool:
        if min(self._window.pixels) < 1:
            return bool(self._pending)
        return bool(
            (self._viewer.is_busy and not self._is_broken)
            or self._pending
            or self._panel_frames > 0
            or self._input.is_holding
            or self._film.is_busy
            or (self._overlay is not None and self._overlay.is_busy)
        )

    def _frame(self, seconds: float) -> None:
        sizes = self._window.sizes
        size = sizes[1]
        self._perform_pending(size)
        if self._window.hide_cursor(self._input.is_looking):
            self._input.cursor_jumped(*self._window.cursor)
        controls = self._input.take(orbiting=self._viewer.flight.orbiting)
        self._has_input = self._wants_release = False
        if self._shader_watch.poll():
            self._after_reload()
        if self._film.is_busy:
            drew = self._film.step(self._interrupt_film)
        else:
            drew = self._render(combined(controls, gamepad()), seconds, size)
        # Before `drew` is looked at: lines go while pictures follow one another, too.
        if self._viewer.messages.expire() or drew:
            drew = True
            # Text that has changed its length takes another frame to fit its window.
            self._panel_frames = max(self._panel_frames, 2)
        if min(size) > 0 and (drew or self._panel_frames > 0):
            self._panel_frames = max(0, self._panel_frames - 1)
            self._draw(sizes, seconds)

    def _perform_pending(self, size: tuple[int, int]) -> None:
        """Do what events have asked for, once there is a picture that it may be about.

        After a frame that was given up there is none; the next one is coarse, and comes
        whatever happens.
        """
        draws = min(size) > 0 and not (self._is_broken or self._film.is_busy)
        if draws and not self._viewer.has_drawing:
            self._viewer.touch()
            return
        pending, self._pending = self._pending, []
        for act in pending:
            act()

    def _render(self, controls: Controls, seconds: float, size: tuple[int, int]) -> bool:
        """Let the viewer draw; return whether there is another picture."""
        if self._is_broken:
            return False
        try:
            return self._viewer.frame(controls, seconds, size, self._between_slices)
        except Interrupted:
            return False
        except ShaderError as error:
            # A variant that was never compiled has no last good version.
            self._is_broken = True
            self._show_faults((*self._shader_watch.faults, str(error)))
            return False
        # What a file, a preset or a flight has led to: go back to where it worked.
        except Exception as error:
            if not self._viewer.step_back():
                raise
            text = f"cannot be drawn: {fault_text(error)}"
            self._viewer.say(text, is_fault=True)
            print(f"ssdo-gl: {text}", file=sys.stderr)
            return False

    def _draw(self, sizes: tuple[tuple[int, int], tuple[int, int]], seconds: float) -> None:
        """Show the picture, and the panel over it, in a window as `GlfwWindow.sizes` has it."""
        self._drawn_at = time.perf_counter()
        screen = self._window.device.gl.screen
        if self._viewer.presenter.picture is not None:
            self._viewer.presenter.copy_to(screen, sizes[1])
        if self._overlay is not None:
            self._overlay.compose(screen, *sizes, seconds)
        else:
            self._say_in_title()
        self._window.swap()

    def _say_in_title(self) -> None:
        """Without a panel the title is where there is room for a line."""
        viewer = self._viewer
        said = [line.text for line in viewer.messages.lines]
        said = said or [f"{viewer.view.method} {viewer.view.aov}"]
        self._window.set_title(f"{self._title} - {said[-1]}")

    def _between_slices(self, what: str, done: int, total: int) -> None:
        """While a frame is in the making: hear of events, let the panel answer.

        The frame is given up for one that somebody wants more.
        """
        glfw.poll_events()
        self._beat()
        is_edited = self._overlay is not None and self._overlay.is_busy
        wants_another = self._has_input or self._viewer.is_outdated(is_edited=is_edited)
        if self._window.should_close or (self._viewer.can_be_given_up and wants_another):
            raise Interrupted

    def _beat(self) -> None:
        """Draw the panel over the picture as it is, if it has heard of anything."""
        seconds = time.perf_counter() - self._drawn_at
        if self._panel_frames < 1 or seconds < BEAT_SECONDS:
            return
        sizes = self._window.sizes
        if min(sizes[1]) > 0 and self._viewer.presenter.picture is not None:
            self._panel_frames -= 1
            self._viewer.present_again(sizes[1])
            self._draw(sizes, seconds)

    def _interrupt_film(self, what: str, done: int, total: int) -> None:
        glfw.poll_events()
        if self._wants_release or self._window.should_close:
            raise Interrupted

    # --- events --------------------------------------------------------------------

    def on_key(self, key: int, action: int, mods: int) -> None:
        """Hand a key to a text field, or to the input map."""
        self._panel_frames = PANEL_FRAMES
        if self._overlay is not None:
            self._overlay.key(key, action, mods)
            if self._overlay.wants_keyboard and action != glfw.RELEASE:
                return
        self._perform_later(self._input.key(key, action, mods))
        self._has_input |= self._input.is_holding

    def on_character(self, code: int) -> None:
        """Hand a character to a text field."""
        if self._overlay is not None:
            self._overlay.character(code)

    def on_button(self, button: int, action: int) -> None:
        """Hand a mouse button to a widget, the divider, or the input map."""
        self._panel_frames = PANEL_FRAMES
        if self._overlay is not None:
            self._overlay.button(button, action)
            if self._overlay.wants_mouse and action == glfw.PRESS:
                return
        if button == glfw.MOUSE_BUTTON_LEFT:
            x, width = self._input.cursor_px[0], self._window.size[0]
            self._divider.press(action == glfw.PRESS, x, width)
        self._perform_later(self._input.button(button, action))

    def on_cursor(self, x: float, y: float) -> None:
        """Hand the cursor to widgets, the divider and the input map."""
        self._panel_frames = PANEL_FRAMES
        self._input.cursor(x, y)
        self._has_input |= self._input.is_looking or self._input.is_orbiting
        if self._overlay is not None:
            if self._input.is_looking:
                self._overlay.cursor_left()
            else:
                self._overlay.cursor(x, y)
        if self._input.is_dragging:
            self._divider.drag(x, self._window.size[0])

    def on_scroll(self, x: float, y: float) -> None:
        """Hand the wheel to the panel, or to the input map."""
        self._panel_frames = PANEL_FRAMES
        if self._overlay is not None:
            self._overlay.scroll(x, y)
            if self._overlay.wants_mouse:
                return
        self._has_input = True
        self._input.scroll(y)

    def on_focus(self, has_focus: bool) -> None:
        """Let go of everything when the keyboard goes to another window."""
        self._panel_frames = PANEL_FRAMES
        if not has_focus:
            self._input.focus_lost()
            self._divider.let_go()
        if self._overlay is not None:
            self._overlay.focus(has_focus)

    def on_drop(self, paths: list[str]) -> None:
        """Open the first of the dropped files."""
        self._panel_frames = PANEL_FRAMES
        self._has_input = True
        self._pending += [partial(self._open, path) for path in paths[:1]]

    def on_change(self) -> None:
        """Draw again, for another size or scale."""
        self._panel_frames = PANEL_FRAMES
        self._has_input = True
        if self._overlay is not None:
            self._overlay.rescale(self._window.content_scale)

    def _perform_later(self, action: Action | None) -> None:
        if action is not None:
            self._has_input = True
            self._pending.append(partial(perform, action, self._viewer, self))
            self._wants_release |= action.command == Command.RELEASE

    def _open(self, path: str) -> None:
        if open_file(path, self._viewer):
            self._title = f"{Path(path).name} - ssdo_gl"
            self._window.set_title(self._title)

    # --- what commands ask of the window -------------------------------------------

    def cursor_uv(self) -> tuple[float, float]:
        """Return the cursor's place in the picture; its middle while it is hidden."""
        (x, y), (width, height) = self._input.cursor_px, self._window.size
        return (0.5, 0.5) if self._input.is_looking else (x / max(1, width), y / max(1, height))

    def set_clipboard(self, text: str) -> None:
        """Put `text` where other programs paste from."""
        self._window.set_clipboard(text)

    def toggle_vsync(self) -> bool:
        """Wait for the display or no longer; return whether it now waits."""
        self._waits = not self._waits
        self._window.set_vsync(self._waits)
        return self._waits

    def toggle_fullscreen(self) -> None:
        """Fill the screen, or go back to a window."""
        self._window.toggle_fullscreen()

    def toggle_panel(self) -> None:
        """Show or hide the panel."""
        if self._overlay is None:
            self._viewer.say(_NO_PANEL)
        else:
            self._overlay.shows_panel = not self._overlay.shows_panel

    def toggle_help(self) -> None:
        """Show or hide the list of keys."""
        if self._overlay is None:
            self._viewer.say(_NO_PANEL)
        else:
            self._overlay.shows_help = not self._overlay.shows_help

    def let_go(self) -> None:
        """Hide the list of keys; give up a film."""
        if self._overlay is not None:
            self._overlay.shows_help = False
        self._film.give_up()

    def quit(self) -> None:
        """Close the window after this frame."""
        self._window.ask_to_close()

    def toggle_film(self) -> None:
        """Begin to export the camera path, or give it up."""
        self._film.toggle()

    def reload_shaders(self) -> None:
        """Compile what has changed on disk."""
        self._shader_watch.reload()
        self._after_reload()

    def _after_reload(self) -> None:
        self._is_broken = False
        self._viewer.restart()
        self._show_faults(self._shader_watch.faults)
        if not self._shader_watch.faults:
            self._viewer.say("shaders are up to date")

    def _show_faults(self, faults: tuple[str, ...]) -> None:
        self._panel_frames = PANEL_FRAMES
        if self._overlay is not None:
            self._overlay.show_faults(faults)
        for fault in faults:
            print(f"ssdo-gl: {fault}", file=sys.stderr)
