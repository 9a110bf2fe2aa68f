"""Bookmarked views and the recorded path of a scene, in one file beside the user's work."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from pathlib import Path

from ssdo_gl.film.camera_path import CameraPath, camera_data, camera_from_data
from ssdo_gl.images.files import write_atomically
from ssdo_gl.scene.camera import Camera
from ssdo_gl.settings.fields import SettingError

NUMBERS = range(1, 10)


class ViewsFileError(ValueError):
    """A file of views that cannot be read: one line naming it and the fault."""


@dataclass
class Views:
    """What a person has marked in a scene.

    Attributes
    ----------
    cameras : dict of number 1 to 9 to Camera
    """

    cameras: dict[int, Camera] = field(default_factory=dict)
    path: CameraPath = field(default_factory=CameraPath)


def views_file(source: str, folder: Path) -> Path:
    """Return where the views of a scene named `source` are kept: ``NAME.views.json``."""
    return folder / f"{Path(source).stem}.views.json"


def load_views(path: Path, base: Camera) -> Views:
    """Return the views in `path`; none if it does not exist.

    Raises
    ------
    ViewsFileError
        If it is not what `save_views` writes.
    """
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        bookmarks = data.get("bookmarks", {}) if isinstance(data, dict) else None
        if not isinstance(bookmarks, dict) or not all(map(str.isdecimal, bookmarks)):
            raise ValueError("expected bookmarks and a path")
        cameras = {int(number): camera_from_data(item, base) for number, item in bookmarks.items()}
        return Views(
            {n: camera for n, camera in cameras.items() if n in NUMBERS},
            CameraPath.from_data(data.get("path", [])),
        )
    except FileNotFoundError:
        return Views()
    except OSError as error:
        raise ViewsFileError(f"{path}: cannot be read: {error.strerror}") from None
    except (ValueError, TypeError, OverflowError, RecursionError) as error:
        raise ViewsFileError(f"{path}: is no file of views: {error}") from None


def load_path(path: Path) -> CameraPath:
    """Return the camera path that was recorded into a file of views.

    Raises
    ------
    SettingError
        If there is none.
    """
    # Unlike Path.is_file, this raises nothing over a name too long or a folder not to be read.
    if not os.path.isfile(path):
        raise SettingError(f"{path}: no such file; a window records one with L")
    try:
        recorded = load_views(path, Camera((0.0, 0.0, 1.0), (0.0, 0.0, 0.0))).path
    except ViewsFileError as error:
        raise SettingError(str(error)) from None
    if not recorded.keys:
        raise SettingError(f"{path}: holds no camera path; a window records one with L")
    return recorded


def save_views(path: Path, views: Views) -> None:
    """Write `views` to `path`, whole or not at all.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    data = {
        "bookmarks": {str(n): camera_data(c) for n, c in sorted(views.cameras.items())},
        "path": views.path.to_data(),
    }
    write_atomically(path, (json.dumps(data, indent=1) + "\n").encode())
