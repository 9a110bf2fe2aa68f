"""Drags the line between two methods."""

from __future__ import annotations

from ssdo_gl.window.viewer import Viewer
from ssdo_gl.window.views import divider_hit


class DividerGrip:
    """Drags the divider of a viewer along with the cursor, once it was grabbed."""

    def __init__(self, viewer: Viewer) -> None:
        self._viewer = viewer
        self._holds = False

    @property
    def is_held(self) -> bool:
        """Whether the cursor drags it."""
        return self._holds

    def press(self, presses: bool, x: float, width: int) -> None:
        """Grab the divider if it is at `x` of `width`, or let it go."""
        self._holds = presses and divider_hit(self._viewer.view, x, width)

    def drag(self, x: float, width: int) -> None:
        """Take the divider along to `x` of `width`, if it is held."""
        if self._holds:
            self._viewer.view = self._viewer.view.with_divider(x / max(1, width))

    def let_go(self) -> None:
        """Let go of it wherever it is."""
        self._holds = False
