"""Where the command begins: `ssdo-gl` and ``python -m ssdo_gl``."""

from __future__ import annotations

# Of `signal` only what needs no enum: until the handlers stand, Ctrl-C is a traceback.
import _signal  # type: ignore[import-not-found]
import gc
import os
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence
    from types import FrameType


def leave_at_once(number: int, _frame: FrameType | None = None) -> None:
    """End the process: a signal handler for while nothing has been begun."""
    os.write(2, b"ssdo-gl: interrupted; nothing was written\n")
    os._exit(128 + number)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit code."""
    # An interrupt during half a second of imports would be a traceback out of them: until here
    # nothing else of the package is imported.
    for number in (_signal.SIGINT, _signal.SIGTERM):
        _signal.signal(number, leave_at_once)
    # What imports make stays: looking through it for waste takes a twentieth of their time.
    gc.disable()
    from ssdo_gl.cli import main as run

    gc.freeze()
    gc.enable()
    return run(arguments)


if __name__ == "__main__":
    sys.exit(main())
