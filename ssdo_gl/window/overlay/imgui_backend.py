"""Draws Dear ImGui into framebuffers and feeds it GLFW's events.

ImGui's own backend draws; that for GLFW needs a window, and panels are tested without.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import glfw
import imgui_bundle
import moderngl
import numpy as np
from imgui_bundle import imgui

from ssdo_gl.gpu.context import ContextError

# Height of text in window coordinates, before the display's own scale.
FONT_PX = 15.0
# Of displays; under the lower one, ImGui refuses margins that are rounded to nothing.
SCALES = (0.5, 8.0)
# What `scale_all_sizes` changes.
_STYLE_SIZES = tuple(
    name
    for name in dir(imgui.Style)
    if isinstance(getattr(imgui.Style(), name), (float, imgui.ImVec2))
    and not name.startswith(("_", "font"))
)
# Names as both GLFW and ImGui have them; letters and digits follow.
_SHARED_KEYS = (
    "TAB BACKSPACE ENTER ESCAPE INSERT DELETE SPACE HOME END PAGE_UP PAGE_DOWN MINUS PERIOD "
    "COMMA EQUAL SLASH"
)
_KEYS: dict[int, Any] = {
    getattr(glfw, f"KEY_{name}"): getattr(imgui.Key, name.lower()) for name in _SHARED_KEYS.split()
}
_KEYS |= {
    getattr(glfw, f"KEY_{c}"): getattr(imgui.Key, c.lower()) for c in "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
}
_KEYS |= {getattr(glfw, f"KEY_{d}"): getattr(imgui.Key, f"_{d}") for d in range(10)}
_KEYS |= {getattr(glfw, f"KEY_KP_{d}"): getattr(imgui.Key, f"keypad{d}") for d in range(10)}
_KEYS |= {
    glfw.KEY_LEFT: imgui.Key.left_arrow,
    glfw.KEY_RIGHT: imgui.Key.right_arrow,
    glfw.KEY_UP: imgui.Key.up_arrow,
    glfw.KEY_DOWN: imgui.Key.down_arrow,
    glfw.KEY_KP_ENTER: imgui.Key.keypad_enter,
    glfw.KEY_KP_DECIMAL: imgui.Key.keypad_decimal,
    glfw.KEY_KP_SUBTRACT: imgui.Key.keypad_subtract,
}
_MODIFIERS = (
    (glfw.MOD_CONTROL, imgui.Key.mod_ctrl),
    (glfw.MOD_SHIFT, imgui.Key.mod_shift),
    (glfw.MOD_ALT, imgui.Key.mod_alt),
    (glfw.MOD_SUPER, imgui.Key.mod_super),
)


class ImguiBackend:
    """One ImGui context that draws with the current OpenGL context.

    Parameters
    ----------
    scale : float
        Of text and widgets, for displays of high density.

    Attributes
    ----------
    is_light : bool
        Whether text is dark on light.
    """

    def __init__(self, scale: float = 1.0) -> None:
        scale = _limited(scale)
        self._context = imgui.create_context()
        imgui.set_current_context(self._context)
        io = imgui.get_io()
        # Positions of panels are the program's business: no file appears beside the user's.
        io.set_ini_filename("")
        io.set_log_filename("")
        if not imgui.backends.opengl3_init("#version 330 core"):
            raise ContextError("the panel finds no OpenGL: install libGL.so.1 (libgl1)")
        fonts = Path(imgui_bundle.__file__).parent / "assets" / "fonts" / "Roboto"
        io.fonts.add_font_from_file_ttf(str(fonts / "Roboto-Regular.ttf"), FONT_PX * scale)
        self.is_light = False
        _style(scale, self.is_light)
        self._scale = self._font_scale = scale
        # Where the cursor has gone since the widgets were issued, and which buttons are down.
        self._moved_to: imgui.ImVec2 | None = None
        self._held: set[int] = set()

    def rescale(self, scale: float) -> None:
        """Follow the window to a display of another density."""
        scale = _limited(scale)
        if scale != self._scale:
            imgui.set_current_context(self._context)
            _style(scale, self.is_light)
            imgui.get_style().font_scale_main = scale / self._font_scale
            self._scale = scale

    def show_light(self, is_light: bool) -> None:
        """Draw dark on light, or light on dark."""
        self.is_light = is_light
        _style(self._scale, is_light)

    @property
    def wants_keyboard(self) -> bool:
        """Whether a text field is being typed into."""
        return bool(imgui.get_io().want_text_input)

    @property
    def wants_mouse(self) -> bool:
        """Whether the cursor is over a widget, or drags one."""
        context = imgui.get_current_context()
        if self._moved_to is not None and not self._held:
            imgui.internal.update_hovered_window_and_capture_flags(self._moved_to)
            return context.hovered_window is not None or context.open_popup_stack.size() > 0
        return bool(imgui.get_io().want_capture_mouse)

    def key(self, key: int, action: int, mods: int) -> None:
        """Take a GLFW key event."""
        io = imgui.get_io()
        for bit, name in _MODIFIERS:
            io.add_key_event(name, bool(mods & bit))
        if key in _KEYS and action != glfw.REPEAT:
            io.add_key_event(_KEYS[key], action == glfw.PRESS)

    def character(self, code: int) -> None:
        """Take a typed character."""
        imgui.get_io().add_input_character(code)

    def cursor(self, x: float, y: float) -> None:
        """Take the cursor's position, window coordinates."""
        self._move_cursor(x, y)

    def cursor_left(self) -> None:
        """Note that there is no cursor: outside the window, or captured by the camera."""
        nowhere = -float(np.finfo(np.float32).max)
        self._move_cursor(nowhere, nowhere)

    def _move_cursor(self, x: float, y: float) -> None:
        self._moved_to = imgui.ImVec2(x, y)
        imgui.get_io().add_mouse_pos_event(x, y)

    def button(self, button: int, action: int) -> None:
        """Take a mouse button event."""
        if 0 <= button < imgui.MouseButton_.count:
            (self._held.add if action == glfw.PRESS else self._held.discard)(button)
            imgui.get_io().add_mouse_button_event(button, action == glfw.PRESS)

    def scroll(self, x: float, y: float) -> None:
        """Take the wheel."""
        imgui.get_io().add_mouse_wheel_event(x, y)

    def focus(self, has_focus: bool) -> None:
        """Note that the window got or lost the keyboard."""
        imgui.get_io().add_focus_event(has_focus)

    def begin(
        self, window_size: tuple[int, int], framebuffer_size: tuple[int, int], seconds: float
    ) -> None:
        """Begin a frame; widgets may be issued until `draw`."""
        imgui.set_current_context(self._context)
        io = imgui.get_io()
        io.display_size = imgui.ImVec2(*window_size)
        io.display_framebuffer_scale = imgui.ImVec2(
            *(f / max(1, w) for f, w in zip(framebuffer_size, window_size, strict=True))
        )
        # ImGui refuses a step of no time.
        io.delta_time = max(seconds, 1e-4)
        imgui.backends.opengl3_new_frame()
        imgui.new_frame()
        self._moved_to = None

    def draw(self, target: moderngl.Framebuffer) -> None:
        """End the frame and draw it over `target`."""
        imgui.render()
        target.use()
        imgui.backends.opengl3_render_draw_data(imgui.get_draw_data())

    def release(self) -> None:
        """Free the textures and the context."""
        imgui.set_current_context(self._context)
        imgui.backends.opengl3_shutdown()
        imgui.destroy_context(self._context)


def _limited(scale: float) -> float:
    low, high = SCALES
    return min(high, max(low, scale))


def _style(scale: float, is_light: bool) -> None:
    """See-through, so that the picture behind stays the main thing."""
    style, fresh = imgui.get_style(), imgui.Style()
    # Scaling rounds down: from what was scaled before, every change would lose some.
    for name in _STYLE_SIZES:
        setattr(style, name, getattr(fresh, name))
    (imgui.style_colors_light if is_light else imgui.style_colors_dark)()
    style.window_rounding = 6.0
    style.frame_rounding = 4.0
    style.grab_rounding = 4.0
    style.window_border_size = 0.0
    style.item_spacing = imgui.ImVec2(8.0, 5.0)
    r, g, b, _ = style.color_(imgui.Col_.window_bg)
    style.set_color_(imgui.Col_.window_bg, imgui.ImVec4(r, g, b, 0.86))
    style.scale_all_sizes(scale)
