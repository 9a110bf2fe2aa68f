"""A line to type the path of a file into, where the system has no dialog for it."""

from __future__ import annotations

from imgui_bundle import imgui

from ssdo_gl.window.overlay.prompt import begin_prompt, end_prompt, is_cancelled, prompt_width

# Of the line, in heights of text.
_WIDTH = 26.0


class PathPrompt:
    """Asks for a path."""

    def __init__(self) -> None:
        self.is_shown = False
        self._text = ""
        self._takes_focus = False

    def show(self) -> None:
        """Ask, with the keyboard in the line."""
        self.is_shown = self._takes_focus = True

    def draw(self, window_size: tuple[int, int]) -> str | None:
        """Issue the widgets; return the path once it was entered."""
        if not self.is_shown:
            return None
        begin_prompt("open", window_size, 0.3, 4)
        width = prompt_width(_WIDTH, window_size)
        imgui.push_text_wrap_pos(width)
        imgui.text("open a model, scene or preset; or drop it on the window")
        imgui.pop_text_wrap_pos()
        if self._takes_focus:
            imgui.set_keyboard_focus_here()
            self._takes_focus = False
        imgui.set_next_item_width(width)
        enters = imgui.InputTextFlags_.enter_returns_true
        entered, self._text = imgui.input_text("##path", self._text, enters)
        entered |= imgui.button("open")
        imgui.same_line()
        self.is_shown = not is_cancelled()
        end_prompt()
        if not entered:
            return None
        path, self._text, self.is_shown = self._text.strip(), "", False
        return path or None
