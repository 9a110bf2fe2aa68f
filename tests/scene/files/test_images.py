"""Textures: images of every kind show what they hold; what is wrong names its file."""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from image_bytes import plain_png, png
from PIL import Image
from scene.fixture_types import ErrorOf, Write

from ssdo_gl.color import linear_from_srgb
from ssdo_gl.scene.files.images import MAX_TEXELS, read_texture
from ssdo_gl.scene.scene_error import SceneError

GREY, RGB, PALETTE, GREY_ALPHA, RGBA = 0, 2, 3, 4, 6


def test_srgb_decoding_has_its_standard_values() -> None:
    values = linear_from_srgb(np.array([0.0, 0.04045, 0.5, 1.0]))
    assert values == pytest.approx([0.0, 0.0031308, 0.2140411, 1.0], abs=1e-7)


@pytest.mark.parametrize("mode", ["RGB", "RGBA", "L", "P", "LA", "1"])
def test_textures_of_every_mode_become_rgba_bytes(mode: str) -> None:
    stream = io.BytesIO()
    Image.new("RGB", (3, 2), (255, 255, 255)).convert(mode).save(stream, "PNG")
    texture = read_texture(stream.getvalue(), "here")
    assert texture.pixels.shape == (2, 3, 4)
    assert texture.pixels.dtype == np.uint8
    assert texture.pixels.min() == 255


@pytest.mark.parametrize(("sample_format", "largest"), [(1, 2**32 - 1), (2, 2**31 - 1)])
def test_grey_of_32_bits_keeps_its_shades(sample_format: int, largest: int, tmp_path: Path) -> None:
    """A TIFF by hand, because Pillow writes signed samples alone."""
    samples = [0, (largest + 1) // 2, largest]
    tags = [(256, 3), (257, 1), (258, 32), (259, 1), (262, 1), (273, 136), (277, 1), (278, 1)]
    tags += [(279, 12), (339, sample_format)]
    entries = b"".join(
        struct.pack("<HHII", tag, 4 if tag in (273, 279) else 3, 1, value) for tag, value in tags
    )
    head = struct.pack("<2sHIH", b"II", 42, 8, len(tags))
    data = head + entries + bytes(4)
    texture = read_texture(data.ljust(136, b"\0") + struct.pack("<3I", *samples), "here")
    assert texture.pixels[0].tolist() == [[v, v, v, 255] for v in (0, 128, 255)]


def test_the_first_row_is_the_top() -> None:
    pixels = np.zeros((2, 1, 3), dtype=np.uint8)
    pixels[0] = (9, 8, 7)
    assert read_texture(png(pixels), "here").pixels[0, 0].tolist() == [9, 8, 7, 255]


def test_pillows_own_guard_is_left_as_it_was() -> None:
    before = Image.MAX_IMAGE_PIXELS
    read_texture(plain_png((0, 0, 0)), "here")
    assert before == Image.MAX_IMAGE_PIXELS


def chunk(kind: bytes, data: bytes) -> bytes:
    check = zlib.crc32(kind + data)
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", check)


def raw_png(
    size: tuple[int, int], depth: int, kind: int, rows: Sequence[bytes], *extra: bytes
) -> bytes:
    """Return a PNG written byte by byte, so that nothing but the reader is tested."""
    header = struct.pack(">IIBBBBB", *size, depth, kind, 0, 0, 0)
    data = zlib.compress(b"".join(b"\0" + row for row in rows))
    return b"".join(
        [
            b"\x89PNG\r\n\x1a\n",
            chunk(b"IHDR", header),
            *extra,
            chunk(b"IDAT", data),
            chunk(b"IEND", b""),
        ]
    )


def words(*samples: int) -> bytes:
    return struct.pack(f">{len(samples)}H", *samples)


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        (raw_png((2, 1), 16, GREY, [words(0x8000, 0x1234)]), [[128] * 3 + [255], [18] * 3 + [255]]),
        (
            raw_png((2, 1), 16, GREY, [words(0x8000, 0x1234)], chunk(b"tRNS", words(0x1234))),
            [[128] * 3 + [255], [18] * 3 + [0]],
        ),
        (
            raw_png((2, 1), 8, GREY, [bytes([5, 9])], chunk(b"tRNS", words(5))),
            [[5, 5, 5, 0], [9, 9, 9, 255]],
        ),
        (
            raw_png((2, 1), 4, GREY, [bytes([0x5A])], chunk(b"tRNS", words(5))),
            [[85, 85, 85, 0], [170, 170, 170, 255]],
        ),
        (
            raw_png((2, 1), 2, GREY, [bytes([0x60])], chunk(b"tRNS", words(1))),
            [[85, 85, 85, 0], [170, 170, 170, 255]],
        ),
        (
            raw_png((2, 1), 1, GREY, [bytes([0x40])], chunk(b"tRNS", words(1))),
            [[0, 0, 0, 255], [255, 255, 255, 0]],
        ),
        (
            raw_png((2, 1), 16, RGB, [words(0x8080, 0x1234, 0xFFFF, 1, 2, 3)]),
            [[128, 18, 255, 255], [0, 0, 0, 255]],
        ),
        (
            raw_png(
                (2, 1),
                16,
                RGB,
                [words(0x8080, 0x1234, 0xFFFF, 1, 2, 3)],
                chunk(b"tRNS", words(0x8080, 0x1234, 0xFFFF)),
            ),
            [[128, 18, 255, 0], [0, 0, 0, 255]],
        ),
        (
            raw_png((1, 1), 16, GREY_ALPHA, [words(0x8080, 0x4040)]),
            [[128, 128, 128, 64]],
        ),
        (
            raw_png((1, 1), 16, RGBA, [words(0x8080, 0x1212, 0xFFFF, 0x4040)]),
            [[128, 18, 255, 64]],
        ),
        (
            raw_png(
                (2, 1),
                4,
                PALETTE,
                [bytes([0x01])],
                chunk(b"PLTE", bytes([10, 20, 30, 40, 50, 60])),
                chunk(b"tRNS", bytes([0, 128])),
            ),
            [[10, 20, 30, 0], [40, 50, 60, 128]],
        ),
    ],
)
def test_every_kind_of_png(data: bytes, expected: list[list[int]]) -> None:
    assert read_texture(data, "here").pixels[0].tolist() == expected


def saved(image: Image.Image, kind: str) -> bytes:
    stream = io.BytesIO()
    image.save(stream, kind)
    return stream.getvalue()


def test_cmyk_is_turned_into_colours() -> None:
    ink = Image.new("CMYK", (8, 8), (0, 255, 255, 0))
    for kind in ("JPEG", "TIFF"):
        red, green, blue, alpha = read_texture(saved(ink, kind), "here").pixels[4, 4].tolist()
        assert red > 250
        assert green < 5
        assert blue < 5
        assert alpha == 255


def test_fractions_of_a_tiff_are_grey() -> None:
    image = Image.fromarray(np.array([[0.0, 0.5, 2.0, np.nan]], dtype=np.float32))
    pixels = read_texture(saved(image, "TIFF"), "here").pixels
    assert pixels[0, :, 0].tolist() == [0, 128, 255, 0]


@pytest.mark.parametrize("name", ["page.png", "page.jpg", "page.eps"])
def test_a_program_in_place_of_a_picture_is_never_run(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Pillow gives such content to Ghostscript, which it looks for on the search path.
    run = tmp_path / "run"
    interpreter = tmp_path / "gs"
    interpreter.write_text(f"#!/bin/sh\ntouch {run}\n")
    interpreter.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    path = tmp_path / name
    path.write_bytes(b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 8 8\n{} loop\n%%EOF\n")
    with pytest.raises(SceneError, match="is not a readable image: expected one of PNG, JPEG"):
        read_texture(path, "here")
    assert not run.exists()


def test_no_object_of_ours_is_shown_for_a_damaged_picture() -> None:
    for data in (b"", b"nothing of the kind", b"\x89PNG\r\n\x1a\n", saved(ink(), "PNG")[:60]):
        with pytest.raises(SceneError) as caught:
            read_texture(data, "here", "leaf")
        assert "'leaf' is not a readable image" in str(caught.value)
        assert "BytesIO" not in str(caught.value)


def ink() -> Image.Image:
    return Image.effect_noise((16, 16), 90.0)


@pytest.mark.parametrize("size", [(16384, 16384), (16384, 4097)])
def test_a_kilobyte_does_not_ask_for_gigabytes(size: tuple[int, int]) -> None:
    data = raw_png(size, 1, GREY, [b""])
    with pytest.raises(SceneError, match=f"at most {MAX_TEXELS} in all"):
        read_texture(data, "here")


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
