"""Which frames a film has, and for each of them the time and the camera. Pure."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from numbers import Integral, Real
from pathlib import Path

from ssdo_gl.film.bookmarks import load_path
from ssdo_gl.film.camera_path import CameraPath
from ssdo_gl.options.run_options import FRAMES_PER_SECOND, FilmOptions, RunOptions
from ssdo_gl.scene.camera import Camera
from ssdo_gl.settings.fields import SettingError, plain, shown

# How long a turntable takes where nothing else is said.
TURN_SECONDS = 8.0
# A day at 60 frames per second, nearly: more is a slip of the finger.
MAX_FRAMES = 5_000_000


@dataclass(frozen=True)
class Shot:
    """One frame of a film.

    Attributes
    ----------
    index : int
        Its number, from 0.
    seconds : float
        Time of an animated scene.
    camera : Camera or None
        None: the scene's own at that time.
    """

    index: int
    seconds: float
    camera: Camera | None


@dataclass(frozen=True)
class Shots:
    """The frames of a film.

    Attributes
    ----------
    path : CameraPath or None
        The camera follows it, held at either end.
    turntable : float or None
        Degrees that the camera turns about its target in the whole film; seen from
        above, it goes counter-clockwise.
    fps : float
        Frames per second.
    start_s : float
        Time of an animated scene in frame 0.
    frames : (int, int), (int, int, int) or None
        First frame, end (not rendered), and how many the whole film has, by default as many
        as the end; None: all of it.

    Raises
    ------
    SettingError
        If nothing says how long the film is, or a number makes no sense.
    """

    path: CameraPath | None = None
    turntable: float | None = None
    fps: float = FRAMES_PER_SECOND
    start_s: float = 0.0
    frames: tuple[int, int] | tuple[int, int, int] | None = None

    def __post_init__(self) -> None:
        numbers = {"fps": self.fps, "turntable": self.turntable or 0.0, "time": self.start_s}
        for name, number in numbers.items():
            if not isinstance(number, Real) or not math.isfinite(number):
                raise SettingError(f"{name} = {shown(number)}: expected a finite number")
        object.__setattr__(self, "fps", plain(self.fps))
        if self.fps <= 0.0:
            raise SettingError(f"fps = {self.fps!r}: expected a number above 0")
        if self.path is not None and self.turntable is not None:
            raise SettingError("path and turntable: give one of them")
        if self.frames is not None:
            _check_frames(self.frames)
        elif self.path is None and self.turntable is None:
            raise SettingError("a film needs its length: a path, a turntable, or a range of frames")

    @property
    def length(self) -> int:
        """How many frames the whole film has."""
        if self.frames is not None:
            return self.frames[-1]
        seconds = TURN_SECONDS if self.path is None else self.path.seconds
        return max(1, round(seconds * self.fps))

    @property
    def indices(self) -> range:
        """The frames that are asked for."""
        return range(self.length) if self.frames is None else range(*self.frames[:2])

    def shot(self, index: int, base: Camera) -> Shot:
        """Return frame `index`; `base` is the camera that is turned, or gives path its up."""
        seconds = index / self.fps
        camera = None
        if self.path is not None:
            camera = self.path.camera(seconds, base)
        elif self.turntable is not None:
            camera = base.orbit(self.turntable * index / self.length)
        return Shot(index, self.start_s + seconds, camera)


def _check_frames(frames: tuple[int, int] | tuple[int, int, int]) -> None:
    """Raise SettingError unless frames are a range within a film."""
    given = f"frames = {shown(frames)}"
    # A range has numbers of its own at these places.
    if not isinstance(frames, tuple | list) or not 2 <= len(frames) <= 3:
        raise SettingError(f"{given}: expected (first, end) or a LENGTH besides")
    if not all(isinstance(number, Integral) for number in frames):
        raise SettingError(f"{given}: expected whole numbers")
    if not 0 <= frames[0] < frames[1] <= frames[-1] <= MAX_FRAMES:
        raise SettingError(f"{given}: expected 0 <= first < end <= length <= {MAX_FRAMES}")


def frames_from_text(text: str) -> tuple[int, int, int]:
    """Return (first, end, length) from ``A:B`` or ``A:B/LENGTH``; without, the length is B.

    Raises
    ------
    SettingError
    """
    match = re.fullmatch(r"(\d{1,7}):(\d{1,7})(?:/(\d{1,7}))?", text.strip(), re.ASCII)
    if match is not None:
        first, end = int(match[1]), int(match[2])
        length = end if match[3] is None else int(match[3])
        if first < end <= length <= MAX_FRAMES:
            return first, end, length
    raise SettingError(
        f"--frames-range {shown(text)}: expected A:B with A < B (frames A to B - 1), or A:B/LENGTH"
        f" for a part of a film; at most {MAX_FRAMES} frames"
    )


def asked_shots(run: RunOptions, film: FilmOptions) -> Shots:
    """Return the frames that a command asks for; raises SettingError."""
    if film.path is not None:
        given = {"camera": run.camera, "projection": run.projection, "turntable": film.turntable}
        for flag, value in given.items():
            if value is not None:
                raise SettingError(f"--{flag} has no effect with --path, which moves the camera")
    elif film.turntable is None and film.frames_range is None:
        raise SettingError(
            "--film: a film needs its length: --turntable, --path VIEWS.json or --frames-range A:B"
        )
    path = None if film.path is None else load_path(Path(film.path))
    frames = None if film.frames_range is None else frames_from_text(film.frames_range)
    return Shots(path, film.turntable, film.fps, run.time, frames)
