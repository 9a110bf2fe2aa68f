"""Writes KTX2 files of Basis Universal, of one colour, for tests."""

from __future__ import annotations

import struct

IDENTIFIER = b"\xabKTX 20\xbb\r\n\x1a\n"


def uastc_block(color: tuple[int, int, int, int]) -> bytes:
    """Return four by four texels of one colour: mode 8 of UASTC."""
    bits = 0b10111
    for channel, value in enumerate(color):
        bits |= value << (5 + 8 * channel)
    return bits.to_bytes(16, "little")


def ktx2(
    color: tuple[int, int, int, int],
    size: tuple[int, int],
    *,
    header_size: tuple[int, int] | None = None,
    vulkan_format: int = 0,
    unpacked: int | None = None,
) -> bytes:
    """Return a file of `size` texels; its header may say something else."""
    blocks = -(-size[0] // 4) * -(-size[1] // 4)
    data = uastc_block(color) * blocks
    # One sample of 128 bits of colour model 166, sRGB, primaries of BT.709.
    description = struct.pack(
        "<III4B4B8B", 44, 0, 2 | 40 << 16, 166, 1, 2, 0, 3, 3, 0, 0, 16, *[0] * 7
    )
    description += struct.pack("<HBB4BII", 0, 127, 3, 0, 0, 0, 0, 0, 0xFFFFFFFF)
    width, height = header_size or size
    head = struct.pack("<9I", vulkan_format, 1, width, height, 0, 0, 1, 1, 0)
    start = 12 + 36 + 32 + 24
    head += struct.pack("<4I2Q", start, len(description), 0, 0, 0, 0)
    place = -(-(start + len(description)) // 16) * 16
    head += struct.pack("<3Q", place, len(data), len(data) if unpacked is None else unpacked)
    return (IDENTIFIER + head + description).ljust(place, b"\0") + data
