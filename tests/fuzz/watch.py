"""What a file may not do while it is read: hang, look elsewhere, run, talk, eat memory."""

from __future__ import annotations

import os
import resource
import signal
import sys
import sysconfig
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ssdo_gl.scene.decoders.client import WORKER

ROOT = Path(__file__).parents[2]
# Where Python, the packages and this project lie: importing is no leak.
OWN = tuple(
    str(Path(path).resolve()) + os.sep
    for path in {sys.prefix, sys.base_prefix, *sysconfig.get_paths().values(), *sys.path, ROOT}
    if path and Path(path).is_dir() and Path(path).resolve() != Path("/")
)
FORBIDDEN = ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.fork",
             "socket.connect", "socket.getaddrinfo", "urllib.Request")  # fmt: skip

_allowed: str | None = None
_faults: list[str] = []


def _audit(event: str, arguments: tuple[Any, ...]) -> None:
    if _allowed is None:
        return
    if event == "subprocess.Popen" and str(WORKER) in arguments[1]:
        return  # what decodes compressed meshes and textures
    if event in FORBIDDEN:
        _faults.append(f"{event} {arguments[:2]!r}")
    elif event == "open" and isinstance(arguments[0], (str, bytes)):
        path = os.path.realpath(os.fsdecode(arguments[0]))
        # A folder is "opened" where a nameless file is made in it, which a reader writes first.
        if not path.startswith((_allowed, os.devnull, *OWN)) and not os.path.isdir(path):
            _faults.append(f"opened {path}")


sys.addaudithook(_audit)


class HangError(BaseException):
    """Raised in what takes too long; no reader catches it."""


@contextmanager
def watched(folder: Path, seconds: float) -> Iterator[list[str]]:
    """Watch what happens inside; the list fills with what may not.

    Files that libraries written in C open by themselves are not seen.
    """
    global _allowed

    def stop(*_: object) -> None:
        raise HangError(f"no end after {seconds:g} s")

    before = signal.signal(signal.SIGALRM, stop)
    _faults.clear()
    _allowed = str(folder.resolve()) + os.sep
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield _faults
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
        _allowed = None


def peak_bytes() -> int:
    """Return the largest memory that this process has held."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


@contextmanager
def address_space(more: int) -> Iterator[None]:
    """Let the process ask for `more` bytes at most, so that the machine survives."""
    before = resource.getrlimit(resource.RLIMIT_AS)
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limit = pages * resource.getpagesize() + more
    resource.setrlimit(resource.RLIMIT_AS, (limit, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)
