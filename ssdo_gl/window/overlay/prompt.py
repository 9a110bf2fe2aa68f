"""Prompts for a path and for a picture: over everything else, in the middle."""

from __future__ import annotations

from imgui_bundle import ImVec2, imgui

from ssdo_gl.settings.methods import METHODS
from ssdo_gl.settings.settings import MAX_SIZE_PX
from ssdo_gl.window.saving import PictureRequest
from ssdo_gl.window.views import METHOD_LABELS

# Of the window's width and height, what a prompt takes at most.
_SHARE = 0.9
# Of text that fits.
_SMALLEST = 0.35
# Of a line for a path and of a picture's controls, in heights of text.
_PATH_WIDTH, _PICTURE_WIDTH = 26.0, 18.0
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
        width = prompt_width(_PATH_WIDTH, window_size)
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


class PicturePrompt:
    """Asks for a picture.

    Attributes
    ----------
    request : PictureRequest or None
        As far as it was entered; None: nothing is asked.
    """

    def __init__(self) -> None:
        self.request: PictureRequest | None = None

    def draw(self, window_size: tuple[int, int]) -> PictureRequest | None:
        """Issue the widgets; return the request once it is to be fulfilled."""
        request = self.request
        if request is None:
            return None
        begin_prompt("picture", window_size, 0.5, 7)
        imgui.push_item_width(prompt_width(_PICTURE_WIDTH, window_size))
        imgui.text("size (pixels)")
        _, (width, height) = imgui.input_int2("##size", list(request.size))
        methods = list(METHODS)
        labels = [METHOD_LABELS[name] for name in methods]
        _, index = imgui.combo("##method", methods.index(request.method), labels)
        _, transparent = imgui.checkbox("transparent background", request.is_transparent)
        imgui.text("file (.png .jpg .webp .exr .npz)")
        _, name = imgui.input_text("##file", request.name)
        size = (min(max(width, 1), MAX_SIZE_PX), min(max(height, 1), MAX_SIZE_PX))
        self.request = request = PictureRequest(size, methods[index], transparent, name.strip())
        saves = imgui.button("save")
        imgui.same_line()
        cancels = is_cancelled()
        imgui.pop_item_width()
        end_prompt()
        if saves or cancels:
            self.request = None
        return request if saves and request.name else None
