"""Files that a scene or model names: relative to it and never outside its folder."""

from __future__ import annotations

import os
from pathlib import Path

from ssdo_gl.scene.scene import SceneError


def contained_file(owner: Path, relative: str, where: str) -> Path:
    """Return the path of a file named inside another file.

    Parameters
    ----------
    owner : Path
        The file that names it.
    relative : str
        As written there; backslashes count as separators.
    where : str
        What to call the place in an error, for example ``scene.toml: texture``.

    Raises
    ------
    SceneError
        If the name is absolute, climbs with ``..``, passes through a symbolic
        link, or names no file. A scene from a stranger must not be able to read
        files beside its own folder.
    """
    parts = Path(relative.replace("\\", "/")).parts
    shown = repr(relative)
    if not parts or "\0" in relative:
        raise SceneError(f"{where} = {shown}: expected the name of a file")
    if Path(relative).is_absolute() or ":" in parts[0] or parts[0] == os.sep:
        raise SceneError(f"{where} = {shown}: must be relative to the folder of {owner.name}")
    if ".." in parts:
        raise SceneError(f"{where} = {shown}: must not leave the folder of {owner.name}")
    path = owner.parent
    for part in parts:
        path = path / part
        if path.is_symlink():
            raise SceneError(f"{where} = {shown}: symbolic links are not followed")
    if not path.is_file():
        raise SceneError(f"{where} = {shown}: no such file in {str(owner.parent)!r}")
    return path
