"""Starts, steps and gives up the film of a viewer's camera path."""

from __future__ import annotations

import dataclasses
import datetime
import time
from pathlib import Path

from ssdo_gl.graph.render_pass import ProgressCallback
from ssdo_gl.images.files import OutputError
from ssdo_gl.window.film.job import FilmJob
from ssdo_gl.window.saving import free_stem
from ssdo_gl.window.viewer import Viewer

# All messages about films replace one another.
_KEY = "film"


class Interrupted(Exception):
    """There was input while something long was running."""


class FilmExport:
    """At most one film in the making, of the left side of `viewer` at full quality."""

    def __init__(self, viewer: Viewer) -> None:
        self._viewer = viewer
        self._job: FilmJob | None = None
        self._began = 0.0

    @property
    def is_busy(self) -> bool:
        """Whether a film is being made."""
        return self._job is not None

    def toggle(self) -> None:
        """Begin a film of the recorded path, or give the present one up.

        Raises
        ------
        OutputError
            If nothing can be written to the viewer's folder.
        """
        viewer = self._viewer
        if self._job is not None:
            self.give_up()
            return
        if not viewer.tour.path.keys:
            viewer.say("no camera path yet: record one with L")
            return
        # A sequence of .png is a folder; its name must be free, too.
        suffix = viewer.film_suffix
        stem = free_stem(viewer.folder, Path(viewer.source).stem, suffix.replace(".png", ""))
        self._job = FilmJob(
            viewer.scene,
            dataclasses.replace(viewer.settings_of_side(0), size=viewer.picture_size),
            viewer.tour.path,
            stem.with_suffix(suffix),
            start_s=viewer.clock.seconds,
            device=viewer.device,
        )
        self._began = time.monotonic()

    def step(self, progress: ProgressCallback | None = None) -> bool:
        """Render one frame; return whether there was one.

        `progress` may raise `Interrupted` to give the film up.
        """
        job = self._job
        if job is None:
            return False
        try:
            job.step(progress)
        except Interrupted:
            self.give_up()
            return True
        except OutputError as error:
            self.give_up()
            self._viewer.say(str(error), is_fault=True)
            return True
        if job.frame is not None:
            self._viewer.show_picture(job.frame)
        seconds = (time.monotonic() - self._began) / max(1, job.done_count)
        left = datetime.timedelta(seconds=round(seconds * (job.frame_count - job.done_count)))
        text = f"film: {job.done_count} of {job.frame_count} frames, {left} left   (Esc gives up)"
        if job.is_done:
            self._job = None
            text = f"wrote {job.out.name}"
        self._viewer.say(text, key=_KEY)
        return True

    def give_up(self) -> None:
        """Leave no trace of the film in the making, if there is one."""
        if self._job is not None:
            self._job.cancel()
            self._job = None
            self._viewer.say("film given up; nothing was written", key=_KEY)
