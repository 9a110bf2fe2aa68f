"""Where the command begins: `ssdo-gl` and ``python -m ssdo_gl``."""

from __future__ import annotations

import signal
import sys
from collections.abc import Sequence

from ssdo_gl.process import leave_at_once


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit code."""
    # An interrupt during half a second of imports would be a traceback out of them.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, leave_at_once)
    from ssdo_gl.cli import main as run

    return run(arguments)


if __name__ == "__main__":
    sys.exit(main())
