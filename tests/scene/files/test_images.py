"""Reading of textures and radiance maps."""

from __future__ import annotations

import io
import struct
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from PIL import Image

from ssdo_gl.images.color import linear_from_srgb
from ssdo_gl.scene.files.images import read_radiance_map, read_texture
from ssdo_gl.scene.files.radiance_hdr import decode_hdr


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
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "PNG")
    assert read_texture(stream.getvalue(), "here").pixels[0, 0].tolist() == [9, 8, 7, 255]


def test_pillows_own_guard_is_left_as_it_was() -> None:
    before = Image.MAX_IMAGE_PIXELS
    stream = io.BytesIO()
    Image.new("RGB", (1, 1)).save(stream, "PNG")
    read_texture(stream.getvalue(), "here")
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
