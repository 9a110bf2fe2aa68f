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
    """Write what was rendered to `out`; several pictures become ``stem-name.png``.

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
        write_atomically(out, npz_bytes(images, meta))
        return
    if suffix == ".exr":
        write_atomically(out, exr_bytes(images, meta))
        return
    for name, path in picture_paths(out, names).items():
        pixels = picture(name, images, extents, alpha=has_alpha(out))
        write_atomically(path, picture_bytes(pixels, suffix))


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
