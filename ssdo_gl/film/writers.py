"""Writes a sequence of pictures: a film, an animated picture, or numbered files.

Whole or not at all: nothing lies under the final name before the last frame is in.
"""

from __future__ import annotations

import io
import os
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ssdo_gl.images.files import OutputError, check_output, png_bytes, write_atomically

# A film in one file, and numbered pictures.
ONE_FILE = (".mp4", ".webm", ".webp", ".gif")
FILM_SUFFIXES = (*ONE_FILE, ".png")
# What browsers play. Of H.264's scale from 51 down to 0, at 10 the noise of an estimator
# survives; VP9 has one of its own, from 63.
VIDEO_OPTIONS: Mapping[str, Sequence[str]] = {
    ".mp4": ("-c:v", "libx264", "-crf", "10"),
    ".webm": ("-c:v", "libvpx-vp9", "-crf", "20", "-b:v", "0"),
}
# A walk through the built-in room: at 92 the mean error is 1 step of 255, for 9 kB a
# frame of 480x270. Every frame is a key frame: what is only patched keeps blocks of
# frames before, twice the error for the same size.
WEBP_OPTIONS = {"quality": 92, "method": 6, "kmin": 0, "kmax": 1}


class _Limits(NamedTuple):
    """Of an animated picture: what it counts time in, and how many of that a frame may last."""

    unit_ms: int
    shortest: int
    longest: int
    side_px: int


# Browsers show a frame of 10 ms or less for 100.
_LIMITS = {
    ".gif": _Limits(10, 2, 65535, 65535),
    ".webp": _Limits(1, 11, 2**24 - 1, 16383),
}


class FilmWriter(Protocol):
    """Takes frames of one size, (height, width, 3) uint8 sRGB, row 0 at the top."""

    def add(self, pixels: NDArray[np.uint8]) -> None:
        """Append a frame."""

    def finish(self) -> None:
        """Put the film under its name."""

    def discard(self) -> None:
        """Leave no trace."""


def film_writer(path: Path, frames_per_second: float) -> FilmWriter:
    """Return a writer for the suffix of `path`.

    ``.mp4`` and ``.webm`` (need imageio-ffmpeg), ``.webp`` and ``.gif`` (animated, endless), or
    ``.png``: a folder of that name without suffix, with 0001.png and so on.

    Raises
    ------
    OutputError
        If the suffix is another one, or the file cannot be created.
    """
    check_output(path, FILM_SUFFIXES)
    suffix = path.suffix.lower()
    if suffix in VIDEO_OPTIONS:
        return _VideoWriter(path, frames_per_second)
    if suffix == ".png":
        return _SequenceWriter(path.with_suffix(""))
    return _AnimationWriter(path, frames_per_second)


class _VideoWriter:
    def __init__(self, path: Path, frames_per_second: float) -> None:
        try:
            import imageio_ffmpeg
        except ImportError:
            raise OutputError(
                f"{path}: {path.suffix} needs imageio-ffmpeg: pip install 'ssdo_gl[film]', "
                "or choose .webp or .gif"
            ) from None
        try:
            self._program: str = imageio_ffmpeg.get_ffmpeg_exe()
        except RuntimeError:
            raise OutputError(f"{path}: {path.suffix} needs ffmpeg on this machine") from None
        self._path = path
        self._rate = Fraction(frames_per_second).limit_denominator()
        # A link stays, and what it points to is replaced.
        self._target = Path(os.path.realpath(path))
        self._folder = Path(tempfile.mkdtemp(prefix=".film-", dir=self._target.parent))
        self._file = self._folder / f"film{path.suffix.lower()}"
        self._encoder: subprocess.Popen[bytes] | None = None

    def add(self, pixels: NDArray[np.uint8]) -> None:
        # The format halves the resolution of colour: both sides must be even.
        height, width = (side - side % 2 for side in pixels.shape[:2])
        if min(height, width) < 2:
            raise OutputError(f"{self._path}: a film needs at least 2x2 pixels")
        if self._encoder is None:
            self._encoder = self._started(width, height)
        assert self._encoder.stdin is not None
        try:
            self._encoder.stdin.write(np.ascontiguousarray(pixels[:height, :width]).data)
        except OSError:
            self._end(self._encoder)
            raise OutputError(f"{self._path}: ffmpeg ended before the film") from None

    def _started(self, width: int, height: int) -> subprocess.Popen[bytes]:
        frames = f"-f rawvideo -pix_fmt rgb24 -s {width}x{height} -r {self._rate} -i -".split()
        coding = (*VIDEO_OPTIONS[self._path.suffix.lower()], "-pix_fmt", "yuv420p")
        try:
            return subprocess.Popen(
                [self._program, "-xerror", "-v", "error", *frames, *coding, str(self._file)],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                start_new_session=True,  # Ctrl-C is for this process
            )
        except OSError as error:
            raise OutputError(f"{self._path}: {self._program}: {error.strerror}") from None

    def _end(self, encoder: subprocess.Popen[bytes]) -> None:
        """Let the encoder write what it still holds; raise OutputError unless all is there."""
        _, said = encoder.communicate()
        if encoder.returncode:
            code = encoder.returncode
            ended = f"exit {code}" if code > 0 else f"ended by {signal.strsignal(-code) or -code}"
            lines = said.decode(errors="replace").splitlines() or [ended]
            # Without the name of its part that says so.
            reason = lines[0].rpartition("] ")[2]
            raise OutputError(f"{self._path}: cannot be encoded: {reason}")

    def finish(self) -> None:
        try:
            if self._encoder is not None:
                self._end(self._encoder)
                self._file.replace(self._target)
        except OSError as error:
            raise OutputError(f"{self._path}: cannot be written: {error.strerror}") from None
        finally:
            self.discard()

    def discard(self) -> None:
        if self._encoder is not None:
            self._encoder.kill()
            self._encoder.communicate()
            self._encoder = None
        shutil.rmtree(self._folder, ignore_errors=True)


class _AnimationWriter:
    def __init__(self, path: Path, frames_per_second: float) -> None:
        self._path = path
        self._suffix = path.suffix.lower()
        limits = _LIMITS[self._suffix]
        self._duration = 1000.0 / frames_per_second / limits.unit_ms
        if not limits.shortest <= self._duration <= limits.longest:
            most = 1000.0 / (limits.shortest * limits.unit_ms)
            least = 1000.0 / (limits.longest * limits.unit_ms)
            raise OutputError(
                f"{path}: {self._suffix} shows {least:.2g} to {most:.3g} frames per second, not"
                f" {frames_per_second:g} (--fps)"
            )
        self._frames: list[Image.Image] = []

    def add(self, pixels: NDArray[np.uint8]) -> None:
        most = _LIMITS[self._suffix].side_px
        if max(pixels.shape) > most:
            raise OutputError(f"{self._path}: {self._suffix} has at most {most}x{most} pixels")
        self._frames.append(Image.fromarray(pixels))

    def finish(self) -> None:
        if not self._frames:
            return
        buffer = io.BytesIO()
        first, *rest = self._frames
        options: dict[str, Any] = {"save_all": True, "append_images": rest, "loop": 0}
        if self._suffix == ".webp":
            options |= WEBP_OPTIONS
        # Each frame ends at the unit that is nearest: the film is as long as it is to be.
        ends = [round(self._duration * n) for n in range(len(self._frames) + 1)]
        options["duration"] = [int(n) * _LIMITS[self._suffix].unit_ms for n in np.diff(ends)]
        try:
            first.save(buffer, format=self._suffix[1:].upper(), **options)
        except (OSError, ValueError, OverflowError) as error:
            raise OutputError(f"{self._path}: cannot be encoded: {error}") from None
        write_atomically(self._path, buffer.getvalue())

    def discard(self) -> None:
        self._frames.clear()


class _SequenceWriter:
    def __init__(self, folder: Path) -> None:
        if folder.exists():
            raise OutputError(f"{folder}: exists already; choose another name for the pictures")
        self._folder = folder
        self._partial = Path(tempfile.mkdtemp(prefix=".film-", dir=folder.parent))
        self._count = 0

    def add(self, pixels: NDArray[np.uint8]) -> None:
        self._count += 1
        write_atomically(self._partial / f"{self._count:04d}.png", png_bytes(pixels))

    def finish(self) -> None:
        # A private folder becomes what a plain mkdir would have made.
        self._partial.chmod(0o755)
        self._partial.replace(self._folder)

    def discard(self) -> None:
        shutil.rmtree(self._partial, ignore_errors=True)
