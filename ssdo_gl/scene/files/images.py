"""Textures that scenes refer to, and how large an image may be."""

from __future__ import annotations

import io
import struct
import warnings
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from ssdo_gl.foreign_output import foreign_output_held
from ssdo_gl.scene.decoders import DecoderError, decoded_basis
from ssdo_gl.scene.files.paths import read_file
from ssdo_gl.scene.material import Texture, Wrap
from ssdo_gl.scene.scene_error import SceneError

# The smallest maximum texture size among current desktop OpenGL drivers.
MAX_SIDE_PX = 16384
# A kilobyte of PNG can ask for any number of texels; so many fill 256 MiB, and with
# their mip maps and copies on the way a gigabyte.
MAX_TEXELS = 1 << 26
# Of all images of one model file: 2 GiB. Eight kilobytes of PNG could ask for 32 GiB.
MAX_MODEL_TEXELS = 1 << 29
_KTX2 = b"\xabKTX 20\xbb\r\n\x1a\n"
# What Pillow may take a texture for, whatever its name. Of the rest some run programs
# (EPS starts Ghostscript), and none is a texture.
TEXTURE_FORMATS = (
    "PNG",
    "JPEG",
    "WEBP",
    "BMP",
    "DDS",
    "GIF",
    "PCX",
    "PPM",
    "SGI",
    "TGA",
    "TIFF",
)


def read_texture(
    source: Path | bytes,
    where: str,
    name: str = "",
    wrap: tuple[Wrap, Wrap] = ("repeat", "repeat"),
    most: int = MAX_TEXELS,
    is_data: bool = False,
) -> Texture:
    """Decode an image file into an RGBA texture, sRGB-encoded unless it is data.

    Its content decides what it is, not its name. Sixteen bits a channel become eight.

    Parameters
    ----------
    source : Path or bytes
        The file or its contents.
    where : str
        What to call the place in an error.
    most : int
        How many texels it may have.
    is_data : bool
        As in `Texture`.

    Raises
    ------
    SceneError
        If it is no image, or its header asks for more than `check_size` allows; the
        header is checked before anything is decoded.
    """
    shown = source.name if isinstance(source, Path) else (name or "embedded image")
    data = source if isinstance(source, bytes) else read_file(source, where)
    if data.startswith(_KTX2):
        values = _basis_pixels(data, shown, where, most)
        return Texture(values, name or shown, wrap, is_data=is_data)
    limit = Image.MAX_IMAGE_PIXELS
    try:
        # `check_size` stands in for Pillow's own guard, and says what it found.
        Image.MAX_IMAGE_PIXELS = None
        with warnings.catch_warnings(), foreign_output_held():
            warnings.simplefilter("ignore")  # doubts about metadata
            with Image.open(io.BytesIO(data), formats=TEXTURE_FORMATS) as image:
                check_size(image.size, shown, where, most)
                pixels = rgba_bytes(image)
    except SceneError:
        raise
    except UnidentifiedImageError:
        raise SceneError(
            f"{where}: {shown!r} is not a readable image: expected one of "
            f"{', '.join(TEXTURE_FORMATS)}, KTX2"
        ) from None
    except Exception as error:  # Pillow's decoders raise almost anything on bad data
        reason = " ".join(str(error).split()) or type(error).__name__
        raise SceneError(f"{where}: {shown!r} is not a readable image: {reason}") from None
    finally:
        Image.MAX_IMAGE_PIXELS = limit
    values = np.ascontiguousarray(pixels, dtype=np.uint8)
    return Texture(values, name or shown, wrap, is_data=is_data)


def _basis_pixels(data: bytes, shown: str, where: str, most: int) -> NDArray[np.uint8]:
    """Return the pixels of a KTX2 file of Basis Universal, (height, width, 4).

    Its header, and that of the one level that is read, is held against what a texture may
    have: the largest image, four by four texels in sixteen bytes.
    """
    if len(data) < 104:
        raise SceneError(f"{where}: {shown!r} is not a readable image: truncated KTX2")
    vulkan_format, _, width, height, *_ = struct.unpack_from("<6I", data, len(_KTX2))
    if vulkan_format:
        raise SceneError(
            f"{where}: {shown!r} is a KTX2 image of Vulkan format {vulkan_format}: "
            "expected Basis Universal (ETC1S or UASTC)"
        )
    check_size((width, height), shown, where, most)
    (unpacked,) = struct.unpack_from("<Q", data, 96)
    if unpacked > 16 * (-(-width // 4)) * (-(-height // 4)):
        raise SceneError(f"{where}: {shown!r} is not a readable image: a level is too long")
    try:
        return decoded_basis(data)
    except DecoderError as error:
        raise SceneError(f"{where}: {shown!r} is not a readable image: {error}") from None


def doubled(pixels: NDArray[np.uint8], axis: int, continued: str) -> NDArray[np.uint8]:
    """Return an image twice as long along `axis`, for coordinates halved along it.

    Parameters
    ----------
    continued : "mirror", "repeat" or "clamp"
        What lies beyond the image's end.
    """
    if continued == "mirror":
        beyond = np.flip(pixels, axis)
    elif continued == "repeat":
        beyond = pixels
    else:
        beyond = np.repeat(np.take(pixels, [-1], axis), pixels.shape[axis], axis)
    return np.concatenate([pixels, beyond], axis)


def rgba_bytes(image: Image.Image) -> NDArray[np.uint8]:
    """Return the pixels of an image of any mode, (height, width, 4).

    Pillow's own conversion clips 16-bit grey at 255, and compares the colour that a PNG
    declares transparent with samples that it has already scaled to eight bits.
    """
    transparent = image.info.get("transparency")
    tiles = getattr(image, "tile", None)
    raw_mode = str(tiles[0][3]) if tiles and image.format == "PNG" else ""
    if image.mode.startswith(("I", "F")):
        # Grey: fractions; or 16 bits, also as Pillow's 32-bit integers; or all of these.
        values = np.asarray(image)
        stored = str(tiles[0][3]) if tiles else ""
        largest = 1.0 if image.mode == "F" else 65535.0
        if image.mode == "I" and "I;32" in stored:
            largest = 2.0**31 - 1.0 if "S" in stored else 2.0**32 - 1.0
            values = values.astype(np.int32) if "S" in stored else values.astype(np.uint32)
        scale = 255.0 / largest
        with np.errstate(invalid="ignore"):
            grey = np.nan_to_num(np.rint(np.clip(values * scale, 0.0, 255.0))).astype(np.uint8)
        opaque = np.full_like(grey, 255)
        if isinstance(transparent, int):
            opaque[values == transparent] = 0
        return np.stack([grey, grey, grey, opaque], axis=-1)
    if raw_mode in ("L;2", "L;4") and isinstance(transparent, int):
        image.info["transparency"] = transparent * (85 if raw_mode == "L;2" else 17)
    elif raw_mode == "RGB;16B" and isinstance(transparent, tuple):
        image.info["transparency"] = tuple(sample >> 8 for sample in transparent)
    if image.mode in ("CMYK", "YCbCr", "LAB", "HSV"):
        image = image.convert("RGB")
    return np.asarray(image.convert("RGBA"))


def check_size(size: tuple[int, int], shown: str, where: str, most: int = MAX_MODEL_TEXELS) -> None:
    """Refuse images that no driver could hold, or that would fill the memory.

    Parameters
    ----------
    most : int
        How many texels the file may still hold.
    """
    if min(size) < 1 or max(size) > MAX_SIDE_PX:
        raise SceneError(
            f"{where}: image {shown!r} is {size[0]} x {size[1]} pixels: "
            f"each side must be within 1 to {MAX_SIDE_PX}"
        )
    if size[0] * size[1] > MAX_TEXELS:
        raise SceneError(
            f"{where}: image {shown!r} is {size[0]} x {size[1]} pixels: "
            f"at most {MAX_TEXELS} in all are read"
        )
    if size[0] * size[1] > most:
        raise SceneError(
            f"{where}: image {shown!r} is one too many: "
            f"at most {MAX_MODEL_TEXELS} texels in one file are read"
        )
