"""Asks which picture is to be saved: its size, its method, its background, its name."""

from __future__ import annotations

from imgui_bundle import imgui

from ssdo_gl.effects.methods import METHODS
from ssdo_gl.settings.settings import MAX_SIZE_PX
from ssdo_gl.window.overlay.prompt import begin_prompt, end_prompt, is_cancelled, prompt_width
from ssdo_gl.window.saving import PictureRequest
from ssdo_gl.window.views import METHOD_LABELS

# Of the controls, in heights of text.
_WIDTH = 18.0


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
        imgui.push_item_width(prompt_width(_WIDTH, window_size))
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
