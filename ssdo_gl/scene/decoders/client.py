"""Asks the process that decodes."""

from __future__ import annotations

import atexit
import json
import math
import os
import subprocess
import sys
import threading
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

WORKER = Path(__file__).with_name("worker.py")
# Seconds that one mesh or texture may take; the largest texture takes 2.
MOST_SECONDS = 30.0
# Bytes that an answer may have: four times the largest texture.
MOST_BYTES = 1 << 30
_PACKAGES = {"draco": "DracoPy", "meshopt": "meshopt", "basis": "opengl_basisu"}


class DecoderError(ValueError):
    """What is wrong with compressed data, without the name of its file."""


class MissingDecoderError(DecoderError):
    """The library that would decode it is not installed."""


def decoded_draco(data: bytes, attributes: dict[str, int]) -> tuple[NDArray[Any], ...]:
    """Return the triangles (T, 3) of a Draco mesh and then the attributes of these ids.

    Raises
    ------
    DecoderError
        Also raised by the functions below; `MissingDecoderError` without the library.
    """
    return tuple(_asked("draco", data, attributes))


def decoded_meshopt(data: bytes, count: int, size: int, mode: str, filter_name: str) -> bytes:
    """Return `count` elements of `size` bytes of a buffer view of EXT_meshopt_compression."""
    (found,) = _asked("meshopt", data, count, size, mode, filter_name)
    if found.size != count * size:
        raise DecoderError(f"{found.size} bytes instead of {count} times {size}")
    return found.tobytes()


def decoded_basis(data: bytes) -> NDArray[np.uint8]:
    """Return the largest image of a KTX2 file of Basis Universal, (height, width, 4)."""
    (pixels,) = _asked("basis", data)
    return np.asarray(pixels, np.uint8)


def release() -> None:
    """End the process, if it runs; the next request starts another."""
    global _process
    with _lock:
        process, _process = _process, None
        if process is not None and process[0] == os.getpid():
            process[1].kill()
            process[1].communicate()


# The process that decodes, and the process that started it.
_process: tuple[int, subprocess.Popen[bytes]] | None = None
_lock = threading.RLock()
atexit.register(release)


def _started() -> subprocess.Popen[bytes]:
    global _process
    if _process is None or _process[0] != os.getpid() or _process[1].poll() is not None:
        release()
        # -P: modules beside the script must not stand for others of their name.
        _process = (
            os.getpid(),
            subprocess.Popen(
                [sys.executable, "-P", str(WORKER)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
            ),
        )
    return _process[1]


def _asked(kind: str, data: bytes, *arguments: Any) -> list[NDArray[Any]]:
    package = _PACKAGES[kind]
    if find_spec(package) is None:
        raise MissingDecoderError(
            f"needs the package {package}: pip install 'ssdo_gl[compression]'"
        )
    with _lock:
        try:
            process = _started()
        except OSError as error:
            raise DecoderError(f"the decoder did not start: {error.strerror}") from None
        timer = threading.Timer(MOST_SECONDS, process.kill)
        timer.start()
        try:
            head, arrays = _exchange(process, kind, data, arguments)
        except (OSError, ValueError, EOFError):
            took = f"took more than {MOST_SECONDS:g} s"
            reason = took if timer.finished.is_set() else "too large, or ended the decoder"
            release()
            raise DecoderError(f"damaged: {reason}") from None
        finally:
            timer.cancel()
    if "error" in head:
        raise DecoderError(" ".join(str(head["error"]).split())[:120])
    return arrays


def _exchange(
    process: subprocess.Popen[bytes], kind: str, data: bytes, arguments: tuple[Any, ...]
) -> tuple[dict[str, Any], list[NDArray[Any]]]:
    assert process.stdin is not None and process.stdout is not None
    request = {"kind": kind, "size": len(data), "arguments": arguments}
    process.stdin.write(json.dumps(request).encode() + b"\n")
    process.stdin.write(data)
    process.stdin.flush()
    line = process.stdout.readline()
    if not line:
        raise EOFError
    head: dict[str, Any] = json.loads(line)
    arrays = []
    parts = [(np.dtype(name), shape) for name, shape in head.get("arrays", ())]
    sizes = [math.prod(shape) * numbers.itemsize for numbers, shape in parts]
    if sum(sizes) > MOST_BYTES:
        raise ValueError
    for (numbers, shape), size in zip(parts, sizes, strict=True):
        content = process.stdout.read(size)
        if len(content) < size:
            raise EOFError
        arrays.append(np.frombuffer(content, numbers).reshape(shape))
    return head, arrays
