"""A viewer without a window, driven as a session drives it."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from ssdo_gl.settings import Settings
from ssdo_gl.window.actions import perform
from ssdo_gl.window.camera import Controls
from ssdo_gl.window.input.bindings import Action, Command
from ssdo_gl.window.viewer import Viewer

SIZE = (48, 27)
SETTINGS = Settings("bounce", samples=8, steps=4)
FORWARD = Controls(move=(0.0, 0.0, 1.0))
FRAME_S = 1.0 / 30.0
# Both are averages of the same 16 frames, one in float32 and one in float64.
ROUNDING = 1


class Clock:
    """A clock that is set by hand."""

    seconds = 0.0

    def __call__(self) -> float:
        return self.seconds


class FakeHost:
    """A host that only remembers what goes onto its clipboard."""

    commands: ClassVar[dict[Command, Callable[[], None]]] = {}

    def __init__(self) -> None:
        self.clipboard = ""

    def permits(self, command: Command) -> bool:
        return True

    def cursor_uv(self) -> tuple[float, float]:
        return 0.5, 0.6

    def set_clipboard(self, text: str) -> None:
        self.clipboard = text


def settle(viewer: Viewer, limit: int = 300, size: tuple[int, int] = SIZE) -> int:
    """Let frames pass until nothing is left to do; return how many it took."""
    for count in range(limit):
        # The first frame notices what has changed, as the one after an event does.
        viewer.frame(Controls(), FRAME_S, size)
        if not viewer.is_busy:
            return count
    raise AssertionError("the picture does not come to rest")


def ask(viewer: Viewer, command: Command, number: int = 0) -> FakeHost:
    host = FakeHost()
    perform(Action(command, number), viewer, host)
    return host


def said(viewer: Viewer) -> str:
    return " | ".join(line.text for line in viewer.messages.lines)
