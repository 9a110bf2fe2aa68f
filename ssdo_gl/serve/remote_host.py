"""What commands may ask of a page: its files are not the machine's."""

from __future__ import annotations

from collections.abc import Callable

from ssdo_gl.window.actions import Host
from ssdo_gl.window.input import Command

# Everything that reads or writes no file of the machine and changes nothing for others.
PERMITTED = frozenset(
    {
        *(Command.CAPTURE, Command.RELEASE, Command.FOCUS, Command.PIVOT, Command.ZOOM),
        *(Command.FIT, Command.HOME, Command.NEXT_CAMERA, Command.PROJECT, Command.COLLIDE),
        *(Command.VIEW, Command.NEXT_METHOD, Command.PREVIOUS_METHOD, Command.NEXT_OTHER_METHOD),
        *(Command.SPLIT, Command.ERROR, Command.PAUSE, Command.STEP, Command.GOVERNOR),
        *(Command.UNDO, Command.REDO, Command.RESET, Command.RECALL, Command.PLAY),
        Command.COPY_COMMAND,
    }
)


class RemoteHost(Host):
    """A page: it opens and saves nothing of the machine, and shows its help itself.

    Attributes
    ----------
    clipboard : str
        What the page shall put on its clipboard.
    """

    def __init__(self, cursor_uv: Callable[[], tuple[float, float]]) -> None:
        super().__init__()
        self.clipboard = ""
        self._cursor_uv = cursor_uv

    def permits(self, command: Command) -> bool:
        """Return whether a command stays within the page and its viewer."""
        return command in PERMITTED

    def cursor_uv(self) -> tuple[float, float]:
        return self._cursor_uv()

    def set_clipboard(self, text: str) -> None:
        """Hand `text` to the page."""
        self.clipboard = text
