"""Lines for the person in front of the window; each is shown for a while."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

# Time to read two lines; what went wrong is read twice.
SECONDS = 4.0
FAULT_SECONDS = 8.0
MOST_LINES = 4


@dataclass(frozen=True)
class Message:
    """One line.

    Attributes
    ----------
    is_fault : bool
        Whether something went wrong.
    key : str
        A later message of the same key takes its place.
    until : float
        When it goes, by the clock of its `Messages`.
    """

    text: str
    is_fault: bool
    key: str
    until: float


class Messages:
    """What is shown at present, oldest first.

    Parameters
    ----------
    clock : callable
        Returns seconds that only ever grow.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self.lines: list[Message] = []

    def say(self, text: str, *, is_fault: bool = False, key: str = "") -> None:
        """Show a line; the same text, or one of its `key`, is shown only once."""
        until = self._clock() + (FAULT_SECONDS if is_fault else SECONDS)
        message = Message(text, is_fault, key or text, until)
        others = [line for line in self.lines if line.key != message.key]
        self.lines = [*others, message][-MOST_LINES:]

    def expire(self) -> bool:
        """Drop what has been shown long enough; return whether anything was."""
        kept = [line for line in self.lines if line.until > self._clock()]
        dropped = len(kept) < len(self.lines)
        self.lines = kept
        return dropped
