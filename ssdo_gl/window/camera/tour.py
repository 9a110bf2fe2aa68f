"""Bookmarks and the camera path of a scene: recorded, played, kept in a file."""

from __future__ import annotations

from pathlib import Path

from ssdo_gl.film.bookmarks import Views, load_views, save_views
from ssdo_gl.film.camera_path import CameraPath
from ssdo_gl.images.files import OutputError
from ssdo_gl.scene.camera import Camera


class Tour:
    """What a person has marked in one scene, and the path while it is flown.

    Parameters
    ----------
    file : Path
        Where bookmarks and path are kept; need not exist.
    base : Camera
        Of the scene: gives up and exposure to every view.

    Attributes
    ----------
    fault : str
        Why the file could not be read; empty if it could.
    played_s : float or None
        How far the path has been flown, seconds; None if it is not played.
    """

    def __init__(self, file: Path, base: Camera) -> None:
        self.file = file
        self.base = base
        self.fault = ""
        self._views = Views()
        self._recorded_s: float | None = None
        self.played_s: float | None = None
        try:
            self._views = load_views(file, base)
        except ValueError as error:
            self.fault = str(error)

    @property
    def path(self) -> CameraPath:
        """The recorded path."""
        return self._views.path

    @property
    def numbers(self) -> list[int]:
        """Bookmarks that exist."""
        return sorted(self._views.cameras)

    @property
    def is_recording(self) -> bool:
        """Whether the flight is being recorded."""
        return self._recorded_s is not None

    def store(self, number: int, camera: Camera) -> None:
        """Keep a view as bookmark 1 to 9; raises OutputError if it cannot be written."""
        self._views.cameras[number] = camera
        self._save()

    def recall(self, number: int) -> Camera | None:
        """Return bookmark `number`, if there is one."""
        return self._views.cameras.get(number)

    def start_recording(self, camera: Camera) -> None:
        """Begin a new path at `camera`."""
        self.played_s = None
        self._recorded_s = 0.0
        self._views.path = CameraPath().recorded(0.0, camera)

    def stop_recording(self) -> None:
        """End the recording and keep it; raises OutputError if it cannot be written."""
        self._recorded_s = None
        self._save()

    def _save(self) -> None:
        # What could not be read may be somebody's work.
        if self.fault:
            raise OutputError(f"{self.fault}; move it away to keep views")
        save_views(self.file, self._views)

    def play(self) -> None:
        """Fly the path from its beginning."""
        self._recorded_s = None
        self.played_s = 0.0

    def stop(self) -> None:
        """Stay where the path has come to."""
        self.played_s = None

    def advance(self, seconds: float) -> None:
        """Let time pass for what is played."""
        if self.played_s is not None:
            self.played_s = min(self.played_s + seconds, self.path.seconds)

    def record(self, seconds: float, camera: Camera) -> None:
        """Note where the flight has come to in `seconds`, while recording."""
        if self._recorded_s is not None:
            self._recorded_s += seconds
            self._views.path = self.path.recorded(self._recorded_s, camera)

    @property
    def has_ended(self) -> bool:
        """Whether the path is being played and has come to its end."""
        return self.played_s is not None and self.played_s >= self.path.seconds

    def camera(self) -> Camera | None:
        """Return the camera of the path while it is played."""
        return None if self.played_s is None else self.path.camera(self.played_s, self.base)
