"""Whatever is wrong with an image is said in one line that names its file."""

from __future__ import annotations

import struct
import zlib

import pytest
from scene.fixture_types import ErrorOf, Write

SPHERE = '[[object]]\nshape = "sphere"\nradius = 1\n'


def png_header(width: int, height: int) -> bytes:
    """Return a PNG whose header promises more than its data holds."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"\0" * 9))


@pytest.mark.parametrize("size", [(30000, 30000), (16385, 1), (1, 100_000)])
def test_a_huge_texture_is_refused_by_its_header(
    size: tuple[int, int], write: Write, error_of: ErrorOf
) -> None:
    file = write(
        {
            "huge.png": png_header(*size),
            "s.toml": f'[materials.m]\nalbedo_texture = "huge.png"\n{SPHERE}',
        }
    )
    message = error_of(file)
    assert f"{size[0]} x {size[1]} pixels" in message
    assert "within 1 to 16384" in message


@pytest.mark.parametrize("content", [b"", b"not an image", png_header(4, 4)])
def test_a_damaged_texture_is_refused(content: bytes, write: Write, error_of: ErrorOf) -> None:
    file = write({"t.png": content, "s.toml": f'[materials.m]\nalbedo_texture = "t.png"\n{SPHERE}'})
    message = error_of(file)
    assert "[materials.m] albedo_texture" in message
    assert "'t.png' is not a readable image" in message


@pytest.mark.parametrize(
    ("name", "content", "reason"),
    [
        ("a.hdr", b"", "does not start with"),
        ("a.hdr", b"#?RADIANCE\n\n", "no line '-Y height +X width'"),
        ("a.hdr", b"#?RADIANCE\n\n-Y 2 +X 2\n\1\1", "ends in the middle"),
        ("a.hdr", b"#?RADIANCE\n\n-Y 1 +X 8\n\2\2\0\7", "wrong length"),
        ("a.hdr", b"#?RADIANCE\n\n-Y 1 +X 8\n\2\2\0\x08\x89\1\1\1", "damaged"),
        ("a.hdr", b"#?RADIANCE\n\n-Y 30000 +X 30000\n", "30000 x 30000 pixels"),
        ("a.exr", b"not an image", "not a readable EXR"),
        ("a.jpg", b"", "expected a .hdr or .exr"),
    ],
)
def test_a_damaged_sky_is_refused(
    name: str, content: bytes, reason: str, write: Write, error_of: ErrorOf
) -> None:
    file = write(
        {name: content, "s.toml": f'[environment]\nkind = "map"\npath = "{name}"\n{SPHERE}'}
    )
    message = error_of(file)
    assert reason in message
    assert "[environment] path" in message
