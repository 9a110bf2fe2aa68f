"""A GLFW window with an OpenGL 3.3 core context, and what one asks of it."""

from __future__ import annotations

from typing import Any

import glfw

from ssdo_gl.gpu.context import ContextError, Device, attach_to_window
from ssdo_gl.gpu.driver_cache import leave_full_disk_alone
from ssdo_gl.gpu.glfw_use import errors_of
from ssdo_gl.window.camera import Controls
from ssdo_gl.window.events import Events
from ssdo_gl.window.input import gamepad_controls

# Events of one size follow another by milliseconds; asking takes microseconds.
_SIZE_TRIES = 8
_ADVICE = "to render without a display, use: ssdo-gl SCENE --snapshot OUT.png"


def check_display() -> None:
    """Refuse a window that nothing can show, before anything is done for it.

    Raises
    ------
    ContextError
        If there is no display.
    """
    with errors_of(glfw) as errors:
        if not glfw.init():
            raise _no_window("", errors)
        glfw.terminate()


def _no_window(kind: str, errors: list[str]) -> ContextError:
    reason = "; ".join(dict.fromkeys(errors)) or "GLFW gives no reason"
    return ContextError(f"no window{kind} ({reason}); {_ADVICE}")


class GlfwWindow:
    """A window whose context is current for as long as it lives.

    Parameters
    ----------
    size : (int, int)
        Window coordinates.

    Raises
    ------
    ContextError
        If there is no display, or no OpenGL 3.3 core for a window on it.
    """

    def __init__(self, size: tuple[int, int], title: str) -> None:
        self._errors: list[str] = []
        glfw.set_error_callback(self._on_error)
        leave_full_disk_alone()
        if not glfw.init():
            raise _no_window("", self._errors)
        glfw.default_window_hints()
        for hint, value in {
            glfw.CONTEXT_VERSION_MAJOR: 3,
            glfw.CONTEXT_VERSION_MINOR: 3,
            glfw.OPENGL_PROFILE: glfw.OPENGL_CORE_PROFILE,
            glfw.OPENGL_FORWARD_COMPAT: glfw.TRUE,
            # Everything is drawn elsewhere and copied: depth would be memory for nothing.
            glfw.DEPTH_BITS: 0,
            glfw.STENCIL_BITS: 0,
            glfw.SCALE_TO_MONITOR: glfw.TRUE,
        }.items():
            glfw.window_hint(hint, value)
        # Any: the binding passes None where C has a null pointer.
        self._handle: Any = glfw.create_window(*size, title, None, None)
        if not self._handle:
            glfw.terminate()
            raise _no_window(" with OpenGL 3.3 core", self._errors)
        glfw.make_context_current(self._handle)
        self.set_vsync(True)
        try:
            self.device: Device = attach_to_window()
        except ContextError:
            glfw.destroy_window(self._handle)
            glfw.terminate()
            raise
        self._windowed: tuple[int, int, int, int] | None = None

    def listen(self, listener: Events) -> None:
        """Tell `listener` of everything that happens from now on."""
        window = self._handle
        glfw.set_key_callback(
            window, lambda w, key, code, act, mods: listener.on_key(key, act, mods)
        )
        glfw.set_char_callback(window, lambda w, code: listener.on_character(code))
        glfw.set_mouse_button_callback(window, lambda w, b, act, mods: listener.on_button(b, act))
        glfw.set_cursor_pos_callback(window, lambda w, x, y: listener.on_cursor(x, y))
        glfw.set_scroll_callback(window, lambda w, x, y: listener.on_scroll(x, y))
        glfw.set_window_focus_callback(window, lambda w, has: listener.on_focus(bool(has)))
        # The hints of the binding are those of C; it returns a list of paths.
        on_drop: Any = lambda w, paths: listener.on_drop(list(paths))  # noqa: E731
        glfw.set_drop_callback(window, on_drop)
        glfw.set_window_refresh_callback(window, lambda w: listener.on_change())
        glfw.set_framebuffer_size_callback(window, lambda w, x, y: listener.on_change())
        glfw.set_window_content_scale_callback(window, lambda w, x, y: listener.on_change())

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in window coordinates."""
        width, height = glfw.get_window_size(self._handle)
        return width, height

    @property
    def pixels(self) -> tuple[int, int]:
        """Width and height of the framebuffer; 0 while minimised, on some systems."""
        width, height = glfw.get_framebuffer_size(self._handle)
        return width, height

    @property
    def sizes(self) -> tuple[tuple[int, int], tuple[int, int]]:
        """`size` and `pixels` of one moment: a window that is dragged changes in between."""
        window, pixels = self.size, self.pixels
        for _ in range(_SIZE_TRIES):
            before, (window, pixels) = (window, pixels), (self.size, self.pixels)
            if before == (window, pixels):
                break
        return window, pixels

    @property
    def content_scale(self) -> float:
        """By how much text must grow, in window coordinates, to keep its size.

        Where window coordinates are scaled already (macOS, Wayland), it is 1.
        """
        (window, _), (pixels, _) = self.sizes
        ratio = pixels / window if window > 0 and pixels > 0 else 1.0
        return float(glfw.get_window_content_scale(self._handle)[0]) / ratio

    @property
    def cursor(self) -> tuple[float, float]:
        """The cursor's position, window coordinates."""
        x, y = glfw.get_cursor_pos(self._handle)
        return x, y

    @property
    def should_close(self) -> bool:
        """Whether somebody wants it closed."""
        return bool(glfw.window_should_close(self._handle))

    def ask_to_close(self) -> None:
        """Close it after this frame."""
        glfw.set_window_should_close(self._handle, True)

    def set_title(self, title: str) -> None:
        """Show another title."""
        glfw.set_window_title(self._handle, title)

    def set_clipboard(self, text: str) -> None:
        """Put `text` where other programs paste from."""
        glfw.set_clipboard_string(self._handle, text)

    def set_vsync(self, waits: bool) -> None:
        """Wait for the display before a frame is shown, or not."""
        glfw.swap_interval(int(waits))

    def swap(self) -> None:
        """Show what was drawn."""
        glfw.swap_buffers(self._handle)

    def hide_cursor(self, hides: bool) -> bool:
        """Hide and hold the cursor, or let it go; return whether that is a change."""
        wanted = glfw.CURSOR_DISABLED if hides else glfw.CURSOR_NORMAL
        if glfw.get_input_mode(self._handle, glfw.CURSOR) == wanted:
            return False
        glfw.set_input_mode(self._handle, glfw.CURSOR, wanted)
        if glfw.raw_mouse_motion_supported():
            glfw.set_input_mode(self._handle, glfw.RAW_MOUSE_MOTION, int(hides))
        return True

    def toggle_fullscreen(self) -> None:
        """Fill the monitor that the window is on, or go back to where it was."""
        if self._windowed is not None:
            x, y, width, height = self._windowed
            nowhere: Any = None
            glfw.set_window_monitor(self._handle, nowhere, x, y, width, height, glfw.DONT_CARE)
            self._windowed = None
            return
        monitor = self._monitor()
        if monitor is None:
            return
        self._windowed = (*glfw.get_window_pos(self._handle), *self.size)
        mode = glfw.get_video_mode(monitor)
        glfw.set_window_monitor(
            self._handle, monitor, 0, 0, mode.size.width, mode.size.height, mode.refresh_rate
        )

    def close(self) -> None:
        """Destroy the window and give the display back."""
        self.device.release()
        glfw.destroy_window(self._handle)
        glfw.terminate()

    def _monitor(self) -> Any:
        """Return the monitor that shows the middle of the window, else the primary one."""
        x, y = glfw.get_window_pos(self._handle)
        x, y = x + self.size[0] // 2, y + self.size[1] // 2
        for monitor in glfw.get_monitors() or []:
            left, top = glfw.get_monitor_pos(monitor)
            size = glfw.get_video_mode(monitor).size
            if left <= x < left + size.width and top <= y < top + size.height:
                return monitor
        return glfw.get_primary_monitor()

    def _on_error(self, code: int, text: str | bytes) -> None:
        # The binding gives bytes, whatever its type hints say.
        text = text.decode("utf-8", "replace") if isinstance(text, bytes) else text
        self._errors = [*self._errors[-7:], text]


def gamepad() -> Controls:
    """Return what the first gamepad asks for; nothing if there is none."""
    if not glfw.joystick_is_gamepad(glfw.JOYSTICK_1):
        return Controls()
    state = glfw.get_gamepad_state(glfw.JOYSTICK_1)
    return Controls() if state is None else gamepad_controls(state.axes, state.buttons)


def has_gamepad() -> bool:
    """Whether a gamepad must be asked: it has no events that would wake anybody."""
    return bool(glfw.joystick_present(glfw.JOYSTICK_1))
