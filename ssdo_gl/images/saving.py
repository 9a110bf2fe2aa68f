"""From rendered images to files, by the suffix: pictures, or arrays of linear numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ssdo_gl.images.display import on_white, picture_of
from ssdo_gl.images.files import (
    exr_bytes,
    has_alpha,
    npz_bytes,
    picture_bytes,
    picture_paths,
    write_atomically,
)

Extent = tuple[ArrayLike, ArrayLike]


def write_images(
    out: Path,
    names: Sequence[str],
    images: Mapping[str, NDArray[np.float32]],
    meta: Mapping[str, Any],
    extents: Mapping[str, Extent],
) -> None:
    """Write what was rendered to `out`, as `image_files` has it.

    Raises
    ------
    OutputError
    """
    for path, data in image_files(out, names, images, meta, extents).items():
        write_atomically(path, data)


def image_files(
    out: Path,
    names: Sequence[str],
    images: Mapping[str, NDArray[np.float32]],
    meta: Mapping[str, Any],
    extents: Mapping[str, Extent],
) -> dict[Path, bytes]:
    """Return the files that hold what was rendered; several pictures are ``stem-name.png``.

    What is transparent is shown on white where the kind of file has no alpha.

    Parameters
    ----------
    names : sequence of str
        Pictures to make. That of ``beauty`` is made from ``display``.
    images : mapping
        Arrays (height, width, channels). Files of arrays hold all of them.
    meta : mapping
        What files of arrays say beside them.
    extents : mapping
        Values between which pictures of depth and position are spread; else what they hold.

    Raises
    ------
    OutputError
    """
    suffix = out.suffix.lower()
    if suffix == ".npz":
        return {out: npz_bytes(images, meta)}
    if suffix == ".exr":
        return {out: exr_bytes(images, meta)}
    return {
        path: picture_bytes(picture(name, images, extents, alpha=has_alpha(out)), suffix)
        for name, path in picture_paths(out, names).items()
    }


def picture(
    name: str,
    images: Mapping[str, NDArray[np.float32]],
    extents: Mapping[str, Extent],
    *,
    alpha: bool,
) -> NDArray[np.uint8]:
    """Return the 8-bit picture of an image, as `write_images` writes it.

    Parameters
    ----------
    alpha : bool
        Whether what is transparent stays so, or is shown on white.
    """
    if name != "beauty":
        return picture_of(name, images[name], extents.get(name))
    display = images["display"]
    return picture_of("display", display if alpha else on_white(display))
