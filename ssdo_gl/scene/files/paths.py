"""Files that a scene or model names, and the one way that files are read."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from ssdo_gl.scene.scene_error import SceneError

# How the text begins that Git LFS leaves in place of a file that was not fetched.
_POINTER = b"version https://git-lfs.github.com/spec/"


def check_file(path: Path, where: str) -> None:
    """Raise SceneError unless `path` is a plain file: a pipe or device might never end.

    Nor is what Git LFS leaves in place of a file.
    """
    # Most often the place names the file itself, which need not be named again.
    is_place = where.endswith(str(path))
    shown = "it" if is_place else _shown(str(path))
    named = "" if is_place else f": {shown}"
    try:
        mode = os.stat(path).st_mode
    except (FileNotFoundError, NotADirectoryError):
        raise SceneError(f"{where}: no such file{named}") from None
    except (OSError, ValueError) as error:
        raise SceneError(f"{where}: cannot be read: {_reason(error)}") from None
    if not stat.S_ISREG(mode):
        kind = "a folder" if stat.S_ISDIR(mode) else "a pipe or device"
        raise SceneError(f"{where}: expected a file, but {shown} is {kind}")
    try:
        with path.open("rb") as file:
            is_pointer = file.read(len(_POINTER)) == _POINTER
    except OSError as error:
        raise SceneError(f"{where}: cannot be read: {_reason(error)}") from None
    if is_pointer:
        raise SceneError(f"{where}: {shown} is a pointer of Git LFS: run 'git lfs pull'")


def read_file(path: Path, where: str) -> bytes:
    """Return the contents of a plain file.

    Raises
    ------
    SceneError
        If it cannot be read, whatever the reason.
    """
    check_file(path, where)
    try:
        return path.read_bytes()
    except MemoryError:
        raise SceneError(f"{where}: is larger than the free memory") from None
    except OSError as error:
        raise SceneError(f"{where}: cannot be read: {_reason(error)}") from None


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
    shown = _shown(relative)
    if not parts or "\0" in relative:
        raise SceneError(f"{where} = {shown}: expected the name of a file")
    if Path(relative).is_absolute() or ":" in parts[0] or parts[0] == os.sep:
        raise SceneError(f"{where} = {shown}: must be relative to the folder of {owner.name}")
    if ".." in parts:
        raise SceneError(f"{where} = {shown}: must not leave the folder of {owner.name}")
    path = owner.parent
    try:
        for part in parts:
            path = path / part
            if stat.S_ISLNK(os.lstat(path).st_mode):
                raise SceneError(f"{where} = {shown}: symbolic links are not followed")
        if not stat.S_ISREG(os.stat(path).st_mode):
            raise SceneError(f"{where} = {shown}: is not a file")
    except (FileNotFoundError, NotADirectoryError):
        raise SceneError(f"{where} = {shown}: no such file in {str(owner.parent)!r}") from None
    except (OSError, ValueError) as error:
        raise SceneError(f"{where} = {shown}: cannot be read: {_reason(error)}") from None
    return path


def _shown(name: str) -> str:
    return repr(name if len(name) <= 120 else name[:117] + "...")


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)
