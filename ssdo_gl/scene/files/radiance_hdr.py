"""Decoder of Radiance .hdr images (RGBE, flat or run-length encoded).

Format: G. Ward, "Real Pixels", Graphics Gems II, 1991, and the file format notes of
the Radiance distribution (picture "-Y height +X width").
"""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

# Scanlines of these widths may be run-length encoded component by component.
_RLE_WIDTHS = range(8, 32768)


def decode_hdr(data: bytes, check_size: Callable[[tuple[int, int]], None]) -> NDArray[np.float32]:
    """Return linear radiance, shape (height, width, 3), row 0 at the top.

    Parameters
    ----------
    check_size : callable
        Called with (width, height) of the header before pixels are decoded.

    Raises
    ------
    ValueError
        If the data is not such an image or ends too early.
    """
    if not data.startswith(b"#?"):
        raise ValueError("it does not start with '#?RADIANCE'")
    header_end = data.find(b"\n\n")
    match = re.match(rb"-Y (\d{1,9}) \+X (\d{1,9})\n", data[header_end + 2 :][:64])
    if header_end < 0 or match is None:
        raise ValueError("its header has no line '-Y height +X width'")
    if b"32-bit_rle_xyze" in data[:header_end]:
        raise ValueError("XYZE colours are not supported; convert it to RGBE")
    height, width = int(match[1]), int(match[2])
    check_size((width, height))
    pixels = np.frombuffer(data, np.uint8, offset=header_end + 2 + match.end())
    start = 0
    rgbe = np.empty((height, width, 4), np.uint8)
    for row in range(height):
        start = _decode_row(pixels, start, rgbe[row])
    # The value is mantissa / 256 * 2^(exponent - 128); exponent 0 stands for black.
    exponent = rgbe[..., 3].astype(np.int32)
    scale = np.where(exponent == 0, 0.0, np.ldexp(1.0, exponent - 136))
    return (rgbe[..., :3] * scale[..., None]).astype(np.float32)


def _decode_row(pixels: NDArray[np.uint8], start: int, row: NDArray[np.uint8]) -> int:
    """Decode one scanline into `row` (width, 4); return where the next one starts."""
    width = len(row)
    head = pixels[start : start + 4]
    encoded = width in _RLE_WIDTHS and len(head) == 4 and head[0] == 2 and head[1] == 2
    if not encoded:
        end = start + 4 * width
        if end > len(pixels):
            raise ValueError("the file ends in the middle of the picture")
        row[:] = pixels[start:end].reshape(width, 4)
        return end
    if int(head[2]) << 8 | int(head[3]) != width:
        raise ValueError("a scanline has the wrong length")
    start += 4
    for component in range(4):
        filled = 0
        while filled < width:
            if start + 1 >= len(pixels):
                raise ValueError("the file ends in the middle of the picture")
            count = int(pixels[start])
            run = count > 128
            count = count - 128 if run else count
            end = start + 2 if run else start + 1 + count
            values = pixels[start + 1 : end]
            if count == 0 or filled + count > width or len(values) < end - start - 1:
                raise ValueError("a scanline is damaged")
            row[filled : filled + count, component] = values
            filled += count
            start = end
    return start
