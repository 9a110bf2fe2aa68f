"""Keeps what libraries print out of our output."""

from __future__ import annotations

import io
import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass

_STREAMS = (1, 2)


@dataclass
class Printed:
    """What was printed, once the block has ended."""

    text: str = ""


@contextmanager
def foreign_output_held() -> Iterator[Printed]:
    """Hold back what a library prints within the block, on either stream.

    Such lines name neither the file nor a cure; the caller says what went wrong, and
    may quote them.
    """
    printed = Printed()
    try:
        held = tempfile.TemporaryFile()  # noqa: SIM115
    except OSError:  # no room
        yield printed
        return
    saved: dict[int, int] = {}
    with held:
        for stream in (sys.stdout, sys.stderr):
            if stream is not None:
                stream.flush()
        for number in _STREAMS:
            try:
                saved[number] = os.dup(number)
            except OSError:  # closed: nothing to keep clean
                continue
            os.dup2(held.fileno(), number)
        try:
            # Some bindings print through Python's own streams.
            with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
                yield printed
        finally:
            for number, copy in saved.items():
                os.dup2(copy, number)
                os.close(copy)
            held.seek(0)
            printed.text = held.read(4096).decode("utf-8", "replace").strip()
