"""The process that decodes: run as a script, it imports nothing of the package.

A request is a line of JSON and `size` bytes; so is the answer, with ``arrays`` (type and
shape of each, whose bytes follow) or ``error``.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

# Address space beyond what the process starts with: the largest texture fills 256 MiB.
MEMORY = 3 << 30


def draco(data: bytes, attributes: dict[str, int]) -> list[NDArray[Any]]:
    """Return triangles (T, 3), then the attributes of these ids (V, N), in order."""
    import DracoPy

    mesh = DracoPy.decode(data)
    found = {entry["unique_id"]: entry["data"] for entry in mesh.attributes}
    arrays = [np.asarray(mesh.faces, np.uint32)]
    for name, number in attributes.items():
        if number not in found:
            raise ValueError(f"no attribute {number} for {name}")
        arrays.append(np.asarray(found[number]))
    return arrays


def meshopt(data: bytes, count: int, size: int, mode: str, filter_name: str) -> list[NDArray[Any]]:
    """Return the bytes of a buffer view."""
    import meshopt

    rows = meshopt.decode_gltf_buffer(data, count, size, mode, filter_name)
    return [np.ascontiguousarray(rows).view(np.uint8).reshape(-1)]


def basis(data: bytes) -> list[NDArray[Any]]:
    """Return the largest image of a texture, (height, width, 4)."""
    import opengl_basisu

    return [np.asarray(opengl_basisu.open(data).transcode("rgba8").data)]


DECODERS: dict[str, Callable[..., list[NDArray[Any]]]] = {
    "draco": draco,
    "meshopt": meshopt,
    "basis": basis,
}


def _limit_memory() -> None:
    try:
        import resource

        with open("/proc/self/statm", encoding="ascii") as file:
            now = int(file.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
        resource.setrlimit(resource.RLIMIT_AS, (now + MEMORY, now + MEMORY))
    except (ImportError, OSError, ValueError):
        pass  # such a system has no limit to set


def _serve(requests: BinaryIO, answers: BinaryIO) -> None:
    while line := requests.readline():
        request = json.loads(line)
        data = requests.read(request["size"])
        arrays: list[NDArray[Any]] = []
        head: dict[str, Any] = {}
        try:
            found = DECODERS[request["kind"]](data, *request["arguments"])
            arrays = [np.ascontiguousarray(array) for array in found]
            head["arrays"] = [(array.dtype.str, array.shape) for array in arrays]
        except MemoryError:
            head["error"] = "needs too much memory"
        except Exception as error:  # each library has its own
            head["error"] = str(error) or type(error).__name__
        answers.write(json.dumps(head).encode() + b"\n")
        for array in arrays if "arrays" in head else ():
            answers.write(array.data)
        answers.flush()


def main() -> None:
    """Answer until the requests end; what libraries print goes nowhere."""
    answers = os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    _limit_memory()
    _serve(sys.stdin.buffer, answers)


if __name__ == "__main__":
    main()
