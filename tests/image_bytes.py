"""Images as the bytes of their files, for tests that write some."""

from __future__ import annotations

import base64
import io
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

# Rows and columns of distinct greys.
GREYS = np.array([[60, 120], [180, 240]], dtype=np.uint8)


def png(pixels: NDArray[Any]) -> bytes:
    """Return a .png of grey, RGB or RGBA bytes, or of grey of 16 bits."""
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "PNG")
    return stream.getvalue()


def plain_png(color: tuple[int, ...], size: tuple[int, int] = (1, 1)) -> bytes:
    """Return a .png of one colour; `size` is (width, height)."""
    return png(np.full((size[1], size[0], len(color)), color, np.uint8))


def png_uri(pixels: NDArray[Any]) -> str:
    """Return a .png as a URI that holds it."""
    return "data:image/png;base64," + base64.b64encode(png(pixels)).decode()
