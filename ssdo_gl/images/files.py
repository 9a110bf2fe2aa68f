"""Writes pictures and arrays to files: whole, or not at all."""

from __future__ import annotations

import io
import json
import os
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ssdo_gl.foreign_output import foreign_output_held
from ssdo_gl.user_error import UserError
from ssdo_gl.whole_files import SPECIAL, is_special, replace_whole

PICTURE_SUFFIXES = (".png", ".jpg", ".jpeg", ".webp")
SUFFIXES = (*PICTURE_SUFFIXES, ".exr", ".npz")
# A PNG on standard output, where a path is expected.
STDOUT = Path("-")
# Of 100. Fine enough that edges and dithered gradients show no blocks.
QUALITY = 95


class OutputError(UserError, ValueError):
    """An output that cannot be written: one line naming the path and the reason."""


def check_output(
    path: Path, suffixes: tuple[str, ...] = SUFFIXES, *, new_folder: bool = False
) -> None:
    """Raise OutputError unless `path` can be created or replaced.

    Called before rendering, so that nobody waits for an image that cannot be kept. With
    `new_folder`, its folder may be one that is still to be made.
    """
    # Of os.path: an answer for names that the file system refuses, too.
    if os.path.isdir(path):
        raise OutputError(f"{path}: is a folder; name a file")
    if is_special(path):
        raise OutputError(f"{path}: {SPECIAL}")
    folder = _behind_links(path).parent
    if os.path.exists(folder) and not os.path.isdir(folder):
        raise OutputError(f"{path}: {folder} is a file, no folder")
    if suffixes and path.suffix.lower() not in suffixes:
        valid = f"{'one of ' * (len(suffixes) > 1)}{', '.join(suffixes)}"
        raise OutputError(f"{path}: the suffix must be {valid}")
    if new_folder and not os.path.isdir(folder):
        check_output(folder, ())
        return
    if not os.path.isdir(folder):
        raise OutputError(f"{path}: the folder {folder} does not exist")
    try:
        path.lstat()
    except FileNotFoundError:
        pass
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror}") from None
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise OutputError(f"{path}: cannot write to {folder}: {error.strerror}") from None
    if path.exists() and not os.access(path, os.W_OK):
        raise OutputError(f"{path}: is not writable")


def _behind_links(path: Path) -> Path:
    return Path(os.path.realpath(path)) if os.path.islink(path) else path


def picture_paths(out: Path, names: Sequence[str]) -> dict[str, Path]:
    """Return the file of each image where `out` is a picture: ``out-name.png`` beside `out`."""
    if len(names) == 1:
        return {names[0]: out}
    return {n: out if n == "beauty" else out.with_stem(f"{out.stem}-{n}") for n in names}


def image_paths(out: Path, names: Sequence[str]) -> list[Path]:
    """Return the files that hold the images `names` where `out` is asked for."""
    return list(picture_paths(out, names).values()) if is_picture(out) else [out]


def write_atomically(path: Path, data: bytes) -> None:
    """Replace `path` by `data` in one step; a failure leaves the old file untouched.

    A link stays, and what it points to is replaced. `STDOUT` is standard output.
    """
    if path == STDOUT:
        write_to_stdout(data)
        return
    try:
        replace_whole(_behind_links(path), data)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror}") from None


def is_picture(path: Path) -> bool:
    """Return whether `path` names a tone-mapped picture, not arrays of linear numbers."""
    return path == STDOUT or path.suffix.lower() in PICTURE_SUFFIXES


def has_alpha(path: Path) -> bool:
    """Return whether the picture that `path` names can be transparent."""
    return path.suffix.lower() not in (".jpg", ".jpeg")


def picture_bytes(pixels: NDArray[np.uint8], suffix: str) -> bytes:
    """Return sRGB `pixels` as a file of the kind that `suffix` names.

    Parameters
    ----------
    pixels : ndarray, shape (height, width, 3 or 4)
        Row 0 at the top. A JPEG takes three channels.
    suffix : str
        One of `PICTURE_SUFFIXES`, in lower case, or empty for `STDOUT`.

    Raises
    ------
    OutputError
        If that kind of file cannot hold so large a picture.
    """
    if suffix in (".png", STDOUT.suffix):
        return png_bytes(pixels)
    buffer = io.BytesIO()
    try:
        if suffix == ".webp":
            Image.fromarray(pixels).save(buffer, format="WEBP", quality=QUALITY)
        else:
            # Without subsampling: coloured light has sharp edges.
            Image.fromarray(pixels).save(buffer, format="JPEG", quality=QUALITY, subsampling=0)
    except (OSError, ValueError) as error:
        height, width = pixels.shape[:2]
        raise OutputError(
            f"a picture of {width}x{height} cannot be a {suffix} file: {error}"
        ) from None
    return buffer.getvalue()


def write_to_stdout(data: bytes) -> None:
    """Write to standard output past its encoding; a reader who has left is no error here.

    Raises
    ------
    OutputError
    """
    sys.stdout.flush()
    try:
        sys.stdout.buffer.write(data)
        sys.stdout.buffer.flush()
    except BrokenPipeError as error:
        lose = getattr(sys.stdout, "lose", None)
        if lose is None:
            raise
        lose(error)
    except (OSError, ValueError) as error:
        raise OutputError(f"standard output: cannot be written: {error}") from None


def png_bytes(pixels: NDArray[np.uint8], **packing: Any) -> bytes:
    """Return sRGB `pixels` (height, width, 1, 3 or 4), row 0 at the top, as a PNG file.

    `packing` is what Pillow knows of it, such as ``compress_level``.
    """
    buffer = io.BytesIO()
    squeezed = pixels[:, :, 0] if pixels.shape[2] == 1 else pixels
    Image.fromarray(squeezed).save(buffer, format="PNG", **packing)
    return buffer.getvalue()


def npz_bytes(images: Mapping[str, NDArray[np.float32]], meta: Mapping[str, Any]) -> bytes:
    """Return `images` (height, width, channels) and ``meta`` as JSON text in an .npz file."""
    buffer = io.BytesIO()
    arrays: dict[str, Any] = {name: np.asarray(a, np.float32) for name, a in images.items()}
    arrays["meta"] = np.array(json.dumps(meta, sort_keys=True))
    np.savez_compressed(buffer, **arrays)
    return buffer.getvalue()


def exr_bytes(images: Mapping[str, NDArray[np.float32]], meta: Mapping[str, Any]) -> bytes:
    """Return `images` as the layers of one multi-layer OpenEXR file.

    ``beauty`` is the unnamed layer (R, G, B, A); every other image is a layer of its
    name: R, G, B for colours, X, Y, Z for vectors, V for a single channel.
    """
    import OpenEXR  # slow to import, and only this format needs it

    channels: dict[str, NDArray[np.float32]] = {}
    for name, image in images.items():
        vector = name.endswith("_ws")
        letters = {1: "V", 2: "XY"}.get(image.shape[2], "XYZA" if vector else "RGBA")
        for index in range(image.shape[2]):
            key = letters[index] if name == "beauty" else f"{name}.{letters[index]}"
            channels[key] = np.ascontiguousarray(image[:, :, index], dtype=np.float32)
    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "comments": json.dumps(meta, sort_keys=True),
    }
    # OpenEXR writes to files only.
    try:
        with tempfile.TemporaryDirectory() as folder, foreign_output_held():
            path = Path(folder) / "image.exr"
            with OpenEXR.File(header, channels) as file:
                file.write(str(path))
            return path.read_bytes()
    except (OSError, RuntimeError) as error:
        reason = " ".join(str(error).split())
        raise OutputError(
            f"an .exr image cannot be built in the folder for temporary files (TMPDIR): {reason}"
        ) from None
