"""Holds signals while native code runs that an exception must not interrupt."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def held_signals() -> Iterator[None]:
    """Let every signal that Python handles, such as Ctrl-C, wait until the block ends."""
    if threading.current_thread() is not threading.main_thread():
        yield  # Python runs handlers in the main thread only.
        return
    received: list[int] = []

    def note(number: int, frame: FrameType | None) -> None:
        received.append(number)

    handlers = {number: signal.getsignal(number) for number in signal.valid_signals()}
    held = {number: handler for number, handler in handlers.items() if callable(handler)}
    try:
        for number in held:
            signal.signal(number, note)
        yield
    finally:
        for number, handler in held.items():
            signal.signal(number, handler)
        for late in dict.fromkeys(received):
            signal.raise_signal(late)


@contextmanager
def whole_before_ctrl_c(told: str) -> Iterator[None]:
    """Hold signals, and let a Ctrl-C that waited say `told`: what the block has done."""
    is_done = False
    try:
        with held_signals():
            yield
            is_done = True
    except KeyboardInterrupt as error:
        raise (KeyboardInterrupt(told) if is_done else error) from None
