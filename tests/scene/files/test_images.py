"""Reading of textures and radiance maps: images of every kind show what they hold."""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from image_bytes import plain_png, png
from PIL import Image

from ssdo_gl.images.color import linear_from_srgb
from ssdo_gl.scene.environment.environment_kinds import MapEnvironment
from ssdo_gl.scene.files.images import MAX_TEXELS, read_radiance_map, read_texture
from ssdo_gl.scene.files.radiance_hdr import decode_hdr
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import SceneError

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


def encoded_row(rgbe: np.ndarray) -> bytes:
    """Return a run-length encoded scanline: runs for equal neighbours, else literals."""
    width = len(rgbe)
    data = bytes([2, 2, width >> 8, width & 255])
    for component in rgbe.T:
        column = 0
        while column < width:
            end = column
            while end < width and component[end] == component[column] and end - column < 127:
                end += 1
            data += bytes([128 + end - column, component[column]])
            column = end
    return data


HEADER = b"#?RADIANCE\nEXPOSURE=1\nFORMAT=32-bit_rle_rgbe\n\n"


@pytest.mark.parametrize("encoded", [True, False])
def test_hdr_round_trip(encoded: bool) -> None:
    rgbe = np.random.default_rng(2).integers(0, 256, (3, 20, 4), dtype=np.uint8)
    rgbe[:, 5:12] = rgbe[:, 5:6]
    rgbe[..., 3] = 130
    rgbe[0, 0] = (50, 60, 70, 0)  # exponent 0 is black
    rgbe[:, 0, 0] = 50  # not the mark of an encoded line
    body = b"".join(encoded_row(row) for row in rgbe) if encoded else rgbe.tobytes()
    image = decode_hdr(HEADER + b"-Y 3 +X 20\n" + body, lambda size: None)
    expected = rgbe[..., :3] / 256.0 * 2.0 ** (130 - 128)
    expected[0, 0] = 0.0
    assert image == pytest.approx(expected, rel=1e-7)
    assert not image[0, 0].any()


def test_literal_stretches_of_a_scanline() -> None:
    literal = bytes([8, 1, 2, 3, 4, 5, 6, 7, 8])
    body = bytes([2, 2, 0, 8]) + literal + bytes([136, 0, 136, 0, 136, 128])
    image = decode_hdr(HEADER + b"-Y 1 +X 8\n" + body, lambda size: None)
    assert image[0, :, 0] == pytest.approx(np.arange(1, 9) / 256.0)


def save_exr(path: Path, channels: dict[str, np.ndarray]) -> Path:
    with OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION}, channels) as file:
        file.write(str(path))
    return path


def test_exr_values_are_exact_and_bad_ones_mended(tmp_path: Path) -> None:
    image = np.full((2, 3, 3), 1e6, dtype=np.float32)
    image[0, 0] = (np.nan, 1.0, 2.0)
    image[0, 1] = (np.inf, 1.0, 2.0)
    image[1, 2] = (-4.0, 1.0, 2.0)
    loaded, note = read_radiance_map(save_exr(tmp_path / "a.exr", {"RGB": image}), "here")
    assert loaded.dtype == np.float32
    assert loaded[0, 0].tolist() == [0.0, 1.0, 2.0]
    assert loaded[0, 1].tolist() == [1e6, 1.0, 2.0]
    assert loaded[1, 2].tolist() == [0.0, 1.0, 2.0]
    assert loaded[1, 0].tolist() == [1e6] * 3
    assert note.startswith("a.exr: 3 texels")


def test_exr_with_one_channel_is_grey(tmp_path: Path) -> None:
    path = save_exr(tmp_path / "y.exr", {"Y": np.full((2, 2), 0.25, dtype=np.float32)})
    loaded, note = read_radiance_map(path, "here")
    assert loaded.tolist() == [[[0.25] * 3] * 2] * 2
    assert note == ""


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


def test_the_same_limit_holds_for_skies(tmp_path: Path) -> None:
    path = tmp_path / "sky.hdr"
    path.write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16384 +X 16384\n")
    with pytest.raises(SceneError, match=f"at most {MAX_TEXELS} in all"):
        read_radiance_map(path, "here")


@pytest.mark.parametrize("scale", [1e15, 3.0])
def test_a_scaled_sky_stays_finite(scale: float, tmp_path: Path) -> None:
    path = tmp_path / "sky.exr"
    image = np.full((2, 4, 3), 0.5, dtype=np.float32)
    image[0, 0] = 3e29
    with OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION}, {"RGB": image}) as file:
        file.write(str(path))
    sky, note = read_radiance_map(path, "here", scale)
    assert np.isfinite(sky).all()
    assert sky[1, 1] == pytest.approx(0.5 * scale)
    assert sky.max() <= 1e30
    assert ("1 texels" in note) == (scale == 1e15)


def test_a_damaged_exr_is_one_line(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "sky.exr"
    image = np.full((64, 64, 3), 0.5, dtype=np.float32)
    with OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION}, {"RGB": image}) as file:
        file.write(str(path))
    data = bytearray(path.read_bytes())
    data[-60:] = b"\xff" * 60
    path.write_bytes(data)
    with pytest.raises(SceneError, match=r"'sky\.exr' is not a readable EXR") as caught:
        read_radiance_map(path, "here")
    assert "\n" not in str(caught.value)
    out, err = capfd.readouterr()
    assert (out, err) == ("", "")


def test_a_scene_may_scale_its_sky(tmp_path: Path) -> None:
    image = np.full((2, 4, 3), 0.5, dtype=np.float32)
    with OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION}, {"RGB": image}) as file:
        file.write(str(tmp_path / "sky.exr"))
    scene = tmp_path / "a.toml"
    scene.write_text(
        "[environment]\nkind = 'map'\npath = 'sky.exr'\nscale = 4\n"
        "[[object]]\nshape = 'sphere'\nradius = 1\n"
    )
    environment = load_scene(scene).environment
    assert isinstance(environment, MapEnvironment)
    assert environment.image.tolist() == [[[2.0] * 3] * 4] * 2
