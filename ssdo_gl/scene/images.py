"""Images that scenes refer to: textures, and lat-long radiance maps."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ssdo_gl.scene.material import Texture
from ssdo_gl.scene.radiance_hdr import decode_hdr
from ssdo_gl.scene.scene import SceneError

# The smallest maximum texture size among current desktop OpenGL drivers.
MAX_SIDE_PX = 16384
# Sums over thousands of paths stay finite in float32; the .hdr format reaches 1.7e38.
MAX_RADIANCE = 1e30


def read_texture(
    source: Path | bytes, where: str, name: str = "", wrap: Literal["repeat", "clamp"] = "repeat"
) -> Texture:
    """Decode an image file into an sRGB-encoded RGBA texture.

    Parameters
    ----------
    source : Path or bytes
        The file or its contents.
    where : str
        What to call the place in an error.

    Raises
    ------
    SceneError
        If it is no image, or its header asks for more than `MAX_SIDE_PX` on a
        side; the header is checked before anything is decoded.
    """
    shown = source.name if isinstance(source, Path) else (name or "embedded image")
    stream = io.BytesIO(source) if isinstance(source, bytes) else source
    limit = Image.MAX_IMAGE_PIXELS
    try:
        # Pillow's own guard counts pixels and would refuse a legitimate 16384 x 16384;
        # the check on the header below stands in for it.
        Image.MAX_IMAGE_PIXELS = None
        with Image.open(stream) as image:
            check_size(image.size, shown, where)
            pixels = np.asarray(image.convert("RGBA"))
    except SceneError:
        raise
    except Exception as error:  # Pillow's decoders raise almost anything on bad data
        reason = " ".join(str(error).split()) or type(error).__name__
        raise SceneError(f"{where}: {shown!r} is not a readable image: {reason}") from None
    finally:
        Image.MAX_IMAGE_PIXELS = limit
    return Texture(np.ascontiguousarray(pixels, dtype=np.uint8), name or shown, wrap)


def check_size(size: tuple[int, int], shown: str, where: str) -> None:
    """Refuse images that no driver could hold as a texture."""
    if min(size) < 1 or max(size) > MAX_SIDE_PX:
        raise SceneError(
            f"{where}: image {shown!r} is {size[0]} x {size[1]} pixels: "
            f"each side must be within 1 to {MAX_SIDE_PX}"
        )


def read_radiance_map(path: Path, where: str) -> tuple[NDArray[np.float32], str]:
    """Read a .hdr or .exr image as (height, width, 3) radiance, finite and >= 0.

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
    return _sanitised(image, path.name)


def _read_hdr(path: Path, where: str) -> NDArray[np.float32]:
    try:
        return decode_hdr(path.read_bytes(), lambda size: check_size(size, path.name, where))
    except SceneError:
        raise
    except (ValueError, OSError) as error:
        message = f"{where}: {path.name!r} is not a readable Radiance image: {error}"
        raise SceneError(message) from None


def _read_exr(path: Path, where: str) -> NDArray[np.float32]:
    import OpenEXR  # only a scene with an .exr map pays for the import

    try:
        with OpenEXR.File(str(path), header_only=True) as header:
            low, high = header.header()["dataWindow"]
            size = (int(high[0] - low[0] + 1), int(high[1] - low[1] + 1))
        check_size(size, path.name, where)
        with OpenEXR.File(str(path), separate_channels=True) as file:
            channels = {name: np.asarray(c.pixels) for name, c in file.channels().items()}
    except SceneError:
        raise
    except Exception as error:  # the bindings raise RuntimeError, TypeError and others
        reason = " ".join(str(error).split())
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
