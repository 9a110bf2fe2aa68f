"""The window that a prompt is asked in: over everything else, in the middle."""

from __future__ import annotations

from imgui_bundle import ImVec2, imgui

_FLAGS = (
    imgui.WindowFlags_.no_decoration
    | imgui.WindowFlags_.always_auto_resize
    | imgui.WindowFlags_.no_move
)


def begin_prompt(name: str, window_size: tuple[int, int], height: float) -> None:
    """Begin the widgets of a prompt; its middle is at a share of the window's height."""
    centre = ImVec2(0.5 * window_size[0], height * window_size[1])
    imgui.set_next_window_pos(centre, imgui.Cond_.always, ImVec2(0.5, 0.5))
    imgui.set_next_window_bg_alpha(1.0)
    imgui.begin(name, None, _FLAGS)


def is_cancelled() -> bool:
    """Offer to give the prompt up; return whether that was chosen."""
    return imgui.button("cancel") or imgui.is_key_pressed(imgui.Key.escape)
