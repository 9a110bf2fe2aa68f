"""What commands may ask of a page: its files are not the machine's."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from ssdo_gl.window.input import Command
from ssdo_gl.window.opening import Recent
from ssdo_gl.window.saving import PictureRequest

if TYPE_CHECKING:
    from ssdo_gl.window.overlay import Overlay

# Everything that reads or writes no file of the machine and changes nothing for others.
PERMITTED = frozenset(
    {
        *(Command.CAPTURE, Command.RELEASE, Command.FOCUS, Command.PIVOT, Command.ZOOM),
        *(Command.FIT, Command.HOME, Command.PROJECT, Command.COLLIDE),
        *(Command.VIEW, Command.NEXT_METHOD, Command.PREVIOUS_METHOD, Command.NEXT_OTHER_METHOD),
        *(Command.SPLIT, Command.ERROR, Command.PAUSE, Command.STEP, Command.GOVERNOR),
        *(Command.UNDO, Command.REDO, Command.RESET, Command.RECALL, Command.PLAY),
        Command.COPY_COMMAND,
    }
)


class RemoteHost:
    """A page, as `actions.Host` describes a window.

    Attributes
    ----------
    clipboard : str
        What the page shall put on its clipboard.
    defer : callable
        Does something between two frames.
    """

    def __init__(self, cursor_uv: Callable[[], tuple[float, float]]) -> None:
        self.overlay: Overlay | None = None
        self.recent = Recent()
        self.clipboard = ""
        self.defer: Callable[[Callable[[], object]], None] = lambda act: None
        self._cursor_uv = cursor_uv

    def permits(self, command: Command) -> bool:
        """Return whether a command stays within the page and its viewer."""
        return command in PERMITTED

    def cursor_uv(self) -> tuple[float, float]:
        """Return the cursor's place in the picture, 0..1 from the top left."""
        return self._cursor_uv()

    def set_clipboard(self, text: str) -> None:
        """Hand `text` to the page."""
        self.clipboard = text

    def let_go(self) -> None:
        """Do nothing: the page closes its help itself, and makes no film."""

    def open(self, path: str) -> None:
        """Do nothing: pages open no files of the machine."""

    def save_picture(self, request: PictureRequest) -> None:
        """Do nothing: a page saves what it shows."""

    def toggle_vsync(self) -> bool:
        """Return True: a browser always waits for the display."""
        return True

    def _not_here(self) -> None:
        """Do nothing: `permits` has refused it."""

    toggle_fullscreen = toggle_panel = toggle_help = toggle_film = _not_here
    ask_for_file = ask_for_picture = reload_shaders = quit = _not_here
