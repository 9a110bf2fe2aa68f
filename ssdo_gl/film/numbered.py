"""Where the frames of a film go that are files of their own."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from pathlib import Path

from ssdo_gl.images.files import SUFFIXES, OutputError, check_output, image_paths

IN_A_FOLDER = "frame_%04d.png"
_NUMBER = re.compile(r"[^%]*%(0?\d)?d[^%]*")


def numbered_pattern(out: Path, film_suffixes: Sequence[str]) -> Path | None:
    """Return the pattern of the frames' files, or None if `out` is one film.

    Raises
    ------
    OutputError
        If `out` is neither a film, nor a folder, nor a pattern such as ``frame_%04d.png``.
    """
    suffix = out.suffix.lower()
    # Of os.path: an answer for names that the file system refuses, too.
    if os.path.isdir(out) or (not suffix and "%" not in out.name and out.name):
        return out / IN_A_FOLDER
    if _NUMBER.fullmatch(out.name) and suffix in SUFFIXES:
        return out
    if suffix in film_suffixes and "%" not in out.name:
        return None
    raise OutputError(
        f"{out}: expected a film ({', '.join(film_suffixes)}), a folder, or a pattern such as"
        f" {IN_A_FOLDER} ({', '.join(SUFFIXES)})"
    )


def frame_paths(pattern: Path, index: int, names: Sequence[str]) -> list[Path]:
    """Return the files of frame `index` that hold the images `names`."""
    return image_paths(frame_path(pattern, index), names)


def frame_path(pattern: Path, index: int) -> Path:
    """Return the name that `pattern` gives to frame `index`."""
    return pattern.with_name(pattern.name % index)


def check_pattern(pattern: Path, names: Sequence[str]) -> None:
    """Raise OutputError unless files of `pattern` can be made, in its folder or a new one."""
    for path in frame_paths(pattern, 0, names):
        check_output(path, new_folder=True)
