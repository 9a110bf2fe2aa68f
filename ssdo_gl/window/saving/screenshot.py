"""A picture of the window with the settings that made it beside it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.images.files import png_bytes, write_atomically


def free_stem(folder: Path, stem: str, suffix: str) -> Path:
    """Return the first of ``STEM-001SUFFIX``, ``-002`` ... that does not exist yet."""
    number = 1
    while (path := folder / f"{stem}-{number:03d}{suffix}").exists():
        number += 1
    return path


def save_screenshot(
    folder: Path, stem: str, pixels: NDArray[np.uint8], meta: Mapping[str, Any]
) -> Path:
    """Write ``STEM-NNN.png`` and ``STEM-NNN.json``; return the former.

    Parameters
    ----------
    pixels : ndarray, shape (height, width, 3)
        sRGB, row 0 at the top.
    meta : mapping
        What made the picture; anything that JSON can hold.

    Raises
    ------
    OutputError
        If the folder cannot be written to.
    """
    path = free_stem(folder, stem, ".png")
    text = json.dumps(meta, indent=2, sort_keys=True, default=str) + "\n"
    write_atomically(path.with_suffix(".json"), text.encode())
    write_atomically(path, png_bytes(pixels))
    return path
