"""Lat-long radiance maps that scenes refer to: .exr, and .hdr (RGBE, flat or run-length encoded).

The latter's format: G. Ward, "Real Pixels", Graphics Gems II, 1991, and the file format notes of
the Radiance distribution (picture "-Y height +X width").
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.foreign_output import foreign_output_held
from ssdo_gl.scene.files.images import MAX_TEXELS, check_size
from ssdo_gl.scene.files.paths import check_file, read_file
from ssdo_gl.scene.scene_error import SceneError

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


# Sums over thousands of paths stay finite in float32; the .hdr format reaches 1.7e38.
MAX_RADIANCE = 1e30


def read_radiance_map(
    path: Path, where: str, scale: float = 1.0
) -> tuple[NDArray[np.float32], str]:
    """Read a .hdr or .exr image as (height, width, 3) radiance, finite and >= 0.

    Parameters
    ----------
    scale : float
        Factor of all values, >= 0.

    Returns
    -------
    image : ndarray, float32, row 0 at the top
    note : str
        What had to be mended; empty if nothing.
    """
    suffix = path.suffix.lower()
    if suffix == ".hdr":
        image = _read_hdr(path, where)
    elif suffix == ".exr":
        image = _read_exr(path, where)
    else:
        raise SceneError(f"{where} = {path.name!r}: expected a .hdr or .exr image")
    with np.errstate(over="ignore", invalid="ignore"):
        # What leaves the range is mended with the rest.
        return _sanitised(image * np.float32(scale), path.name)


def _read_hdr(path: Path, where: str) -> NDArray[np.float32]:
    data = read_file(path, where)
    try:
        return decode_hdr(data, lambda size: check_size(size, path.name, where))
    except SceneError:
        raise
    except ValueError as error:
        message = f"{where}: {path.name!r} is not a readable Radiance image: {error}"
        raise SceneError(message) from None


def _read_exr(path: Path, where: str) -> NDArray[np.float32]:
    check_file(path, where)
    import OpenEXR  # only a scene with an .exr map pays for the import

    try:
        with foreign_output_held() as printed:
            with OpenEXR.File(str(path), header_only=True) as header:
                low, high = header.header()["dataWindow"]
                size = (int(high[0] - low[0] + 1), int(high[1] - low[1] + 1))
                channel_count = len(header.header()["channels"])
            check_size(size, path.name, where)
            if size[0] * size[1] * channel_count > 4 * MAX_TEXELS:
                raise SceneError(
                    f"{where}: image {path.name!r} is {size[0]} x {size[1]} pixels of "
                    f"{channel_count} channels: at most {4 * MAX_TEXELS} numbers are read"
                )
            with OpenEXR.File(str(path), separate_channels=True) as file:
                channels = {name: np.asarray(c.pixels) for name, c in file.channels().items()}
    except SceneError:
        raise
    except Exception as error:  # the bindings raise RuntimeError, TypeError and others
        # What the library printed says more than what its bindings made of it.
        reason = " ".join((printed.text.split("\n", 1)[0] or str(error)).split())[:160]
        raise SceneError(f"{where}: {path.name!r} is not a readable EXR: {reason}") from None
    names = ("R", "G", "B") if "R" in channels else ("Y", "Y", "Y")
    if not all(name in channels for name in names):
        found = ", ".join(sorted(channels))
        raise SceneError(f"{where}: {path.name!r} has channels {found}: expected R, G, B or Y")
    return np.stack([channels[name] for name in names], axis=-1).astype(np.float32)


def _sanitised(image: NDArray[np.float32], name: str) -> tuple[NDArray[np.float32], str]:
    """Replace NaN and negative values by 0, infinite and absurd ones by the largest other."""
    usable = np.isfinite(image) & (image <= MAX_RADIANCE)
    bad = ~usable | (image < 0.0)
    count = int(np.count_nonzero(bad.any(axis=-1)))
    if count == 0:
        return image, ""
    largest = image[usable].max(initial=0.0)
    mended = np.where(image > MAX_RADIANCE, largest, np.where(bad, np.float32(0.0), image))
    note = (
        f"{name}: {count} texels were NaN, negative, infinite or above {MAX_RADIANCE:g} "
        "and were made finite and >= 0"
    )
    return mended.astype(np.float32), note
