"""The cameras that a file offers, and which of them is asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.motion import Trajectory
from ssdo_gl.settings.fields import SettingError, shown
from ssdo_gl.settings.loading import FIT
from ssdo_gl.wording import suggestion


@dataclass(frozen=True, eq=False)
class FileCamera:
    """A camera of a file.

    Attributes
    ----------
    name : str
        As modelling programs show it; may be empty.
    camera : Camera
        As it stands at rest.
    motion : Trajectory or None
        How it moves.
    """

    name: str
    camera: Camera
    motion: Trajectory | None = None


def camera_of_file(cameras: Sequence[FileCamera], which: str | int, source: str) -> FileCamera:
    """Return the one of a name, else of a number from 0 on.

    Raises
    ------
    SettingError
        Listing what `source` has.
    """
    names = [camera.name for camera in cameras]
    if which in names:
        return cameras[names.index(str(which))]
    try:
        index = int(which)
    except ValueError:
        index = -1
    if 0 <= index < len(cameras):
        return cameras[index]
    hint = suggestion(str(which), [*filter(None, names), FIT], lists=False)
    there = "camera" if len(names) == 1 else "cameras"
    has = f"{there} {listed_names(cameras, 20)}" if names else "no cameras"
    raise SettingError(f"camera {shown(which)}: {source} has {has}{hint}")


def listed_names(cameras: Sequence[FileCamera], most: int) -> str:
    """Return number and name of the first cameras, and how many more there are."""
    texts = [f"{i} {shown(item.name)}" if item.name else f"{i}" for i, item in enumerate(cameras)]
    more = f" and {len(texts) - most} more" if len(texts) > most else ""
    return ", ".join(texts[:most]) + more
