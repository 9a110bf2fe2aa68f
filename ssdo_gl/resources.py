"""Finds the shaders and scenes, installed or in a checkout.

In a wheel they lie inside the package. In a checkout (editable install or plain
PYTHONPATH) they lie beside it, so that an edit is live. Everything goes through
`Traversable.read_text`, never through paths: a wheel on `sys.path` may be zipped.
"""

from __future__ import annotations

from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Literal


def folder(kind: Literal["shaders", "scenes"]) -> Traversable:
    """Return the folder of shipped files called `kind`.

    Raises
    ------
    FileNotFoundError
        If the folder is neither inside the package nor beside it in a checkout.
    """
    inside = files("ssdo_gl").joinpath(kind)
    if inside.is_dir():
        return inside
    beside = Path(__file__).resolve().parent.parent
    # Only beside a pyproject.toml: a stray site-packages/shaders of another
    # distribution must never be taken for ours.
    if (beside / "pyproject.toml").is_file() and (beside / kind).is_dir():
        return beside / kind
    raise FileNotFoundError(
        f"the folder {kind!r} is missing from ssdo_gl: reinstall it (pip install --force-reinstall)"
    )
