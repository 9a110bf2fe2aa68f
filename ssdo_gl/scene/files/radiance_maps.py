"""Lat-long radiance maps that scenes refer to."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.foreign_output import foreign_output_held
from ssdo_gl.scene.files.images import MAX_TEXELS, check_size
from ssdo_gl.scene.files.paths import check_file, read_file
from ssdo_gl.scene.files.radiance_hdr import decode_hdr
from ssdo_gl.scene.scene_error import SceneError

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
