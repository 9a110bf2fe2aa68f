"""What Dask loads in each worker process that a command starts for itself."""

from __future__ import annotations

import signal


def dask_setup(_worker: object) -> None:
    """Leave Ctrl-C, which a terminal sends to all processes, to the command: it ends this one."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
