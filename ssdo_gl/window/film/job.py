"""Renders a camera path frame by frame at full quality."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.film.camera_path import CameraPath
from ssdo_gl.film.shots import Shots
from ssdo_gl.film.writers import FilmWriter, film_writer
from ssdo_gl.gpu.context import Device
from ssdo_gl.graph.render_pass import ProgressCallback
from ssdo_gl.images.display import picture_of
from ssdo_gl.options.run_options import FRAMES_PER_SECOND
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

# As many sub-pixel offsets as a snapshot has by default.
ANTIALIAS = 4


class FilmJob:
    """A film in the making, one frame at a time so that a window stays alive.

    Parameters
    ----------
    settings : Settings
        With the size of the film.
    out : Path
        ``.mp4``, ``.webp``, ``.gif``, or ``.png`` for a folder of pictures.
    start_s : float
        Time of an animated scene at the beginning.
    device : Device or None
        An existing device to draw with.

    Attributes
    ----------
    frame : ndarray, shape (height, width, 3), or None
        The last one, sRGB.

    Raises
    ------
    OutputError
        If `out` cannot be written.
    """

    def __init__(
        self,
        scene: Scene,
        settings: Settings,
        path: CameraPath,
        out: Path,
        *,
        frames_per_second: float = FRAMES_PER_SECOND,
        start_s: float = 0.0,
        device: Device | None = None,
    ) -> None:
        self.out = out
        self._shots = Shots(path, fps=frames_per_second, start_s=start_s)
        self.frame_count = self._shots.length
        self.done_count = 0
        self.frame: NDArray[np.uint8] | None = None
        self._writer: FilmWriter = film_writer(out, frames_per_second)
        antialias = max(settings.antialias, ANTIALIAS)
        self._renderer = Renderer(
            scene, dataclasses.replace(settings, antialias=antialias), device=device
        )

    @property
    def is_done(self) -> bool:
        """Whether the film is complete and lies under its name."""
        return self.done_count == self.frame_count

    def step(self, progress: ProgressCallback | None = None) -> None:
        """Render the next frame; after the last one the film is finished.

        Whatever `progress` raises leaves the frame to be rendered again.
        """
        if self.is_done:
            return
        shot = self._shots.shot(self.done_count, self._renderer.scene.camera)
        result = self._renderer.render(
            ["display"], camera=shot.camera, seconds=shot.seconds, progress=progress
        )
        self.frame = picture_of("display", result.whole().images["display"])[:, :, :3]
        self._writer.add(self.frame)
        self.done_count += 1
        if self.is_done:
            try:
                self._writer.finish()
            finally:
                self._renderer.release()

    def cancel(self) -> None:
        """Leave no trace of an unfinished film."""
        if not self.is_done:
            self._writer.discard()
            self._renderer.release()
