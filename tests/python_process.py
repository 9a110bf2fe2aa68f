"""Runs Python in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path


def run_python(
    *arguments: str,
    prefix: tuple[str, ...] = (),
    path: str | Path | None = None,
    cwd: Path | None = None,
    **environment: str,
) -> subprocess.CompletedProcess[str]:
    """Return how Python ended, with what it said.

    `path` is where modules are looked for; by default where this process looks. It is ended
    after two minutes.
    """
    found = os.pathsep.join(sys.path) if path is None else str(path)
    return subprocess.run(
        [*prefix, sys.executable, *arguments],
        env={**os.environ, "PYTHONPATH": found, **environment},
        cwd=cwd,
        capture_output=True,
        text=True,
        timeout=120,
    )
