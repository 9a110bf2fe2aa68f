"""The window that a prompt is asked in: over everything else, in the middle."""

from __future__ import annotations

from imgui_bundle import ImVec2, imgui

# Of the window's width and height, what a prompt takes at most.
_SHARE = 0.9
# Of text that fits.
_SMALLEST = 0.35
_FLAGS = (
    imgui.WindowFlags_.no_decoration
    | imgui.WindowFlags_.always_auto_resize
    | imgui.WindowFlags_.no_move
)


def begin_prompt(name: str, window_size: tuple[int, int], height: float, lines: int) -> None:
    """Begin the widgets of a prompt; its middle is at a share of the window's height.

    `lines` is how many it has: where they do not fit, text is smaller.
    """
    centre = ImVec2(0.5 * window_size[0], height * window_size[1])
    imgui.set_next_window_pos(centre, imgui.Cond_.always, ImVec2(0.5, 0.5))
    imgui.set_next_window_bg_alpha(1.0)
    imgui.begin(name, None, _FLAGS)
    # Over what is said, too.
    imgui.internal.bring_window_to_display_front(imgui.internal.get_current_window())
    style = imgui.get_style()
    # Paddings and gaps stay as they are.
    between = lines * (style.item_spacing.y + 2.0 * style.frame_padding.y)
    room = _SHARE * window_size[1] - between - 2.0 * style.window_padding.y
    fitting = room / (lines * imgui.get_font_size())
    imgui.push_font(None, min(1.0, max(_SMALLEST, fitting)) * style.font_size_base)


def end_prompt() -> None:
    """End what `begin_prompt` has begun."""
    imgui.pop_font()
    imgui.end()


def prompt_width(heights: float, window_size: tuple[int, int]) -> float:
    """Return the width of what is `heights` of text wide, if the window is wide enough."""
    return min(heights * imgui.get_font_size(), _SHARE * window_size[0])


def is_cancelled() -> bool:
    """Offer to give the prompt up; return whether that was chosen."""
    return imgui.button("cancel") or imgui.is_key_pressed(imgui.Key.escape)
