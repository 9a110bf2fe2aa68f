"""What a control says when the cursor rests on it: wrapped, so that it fits into the window."""

from __future__ import annotations

from imgui_bundle import imgui

# In heights of text; of the window.
_WIDTH, _SHARE = 28.0, 0.85


def show_tooltip(text: str) -> None:
    """Show `text` beside the cursor."""
    if not imgui.begin_tooltip():
        return
    width = min(_WIDTH * imgui.get_font_size(), _SHARE * imgui.get_io().display_size.x)
    imgui.push_text_wrap_pos(width)
    imgui.text_unformatted(text)
    imgui.pop_text_wrap_pos()
    imgui.end_tooltip()
