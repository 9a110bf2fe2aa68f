"""Renders the camera path of a viewer frame by frame, so that the window stays alive."""

from __future__ import annotations

import dataclasses
import datetime
import time
from dataclasses import dataclass
from pathlib import Path

from ssdo_gl.film.shots import Shots
from ssdo_gl.film.writers import FilmWriter, film_writer
from ssdo_gl.graph.render_pass import ProgressCallback
from ssdo_gl.images.display import picture_of
from ssdo_gl.images.files import OutputError
from ssdo_gl.renderer import Renderer
from ssdo_gl.window.saving import free_stem
from ssdo_gl.window.viewer import Viewer

# As many sub-pixel offsets as a snapshot has by default.
ANTIALIAS = 4
# All messages about films replace one another.
_KEY = "film"


class Interrupted(Exception):
    """There was input while something long was running."""


@dataclass
class _Film:
    """A film in the making."""

    out: Path
    shots: Shots
    writer: FilmWriter
    renderer: Renderer
    began: float
    done_count: int = 0


class FilmExport:
    """At most one film in the making, of the left side of `viewer` at full quality."""

    def __init__(self, viewer: Viewer) -> None:
        self._viewer = viewer
        self._film: _Film | None = None

    @property
    def is_busy(self) -> bool:
        """Whether a film is being made."""
        return self._film is not None

    def toggle(self) -> None:
        """Begin a film of the recorded path, or give the present one up.

        Raises
        ------
        OutputError
            If nothing can be written to the viewer's folder.
        """
        viewer = self._viewer
        if self._film is not None:
            self.give_up()
            return
        if not viewer.tour.path.keys:
            viewer.say("no camera path yet: record one with L")
            return
        # A sequence of .png is a folder; its name must be free, too.
        suffix = viewer.film_suffix
        stem = free_stem(viewer.folder, Path(viewer.source).stem, suffix.replace(".png", ""))
        out = stem.with_suffix(suffix)
        shots = Shots(viewer.tour.path, start_s=viewer.clock.seconds)
        writer = film_writer(out, shots.fps)
        chosen = viewer.settings_of_side(0)
        settings = dataclasses.replace(
            chosen, size=viewer.picture_size, antialias=max(chosen.antialias, ANTIALIAS)
        )
        renderer = Renderer(viewer.scene, settings, device=viewer.device)
        self._film = _Film(out, shots, writer, renderer, time.monotonic())

    def step(self, progress: ProgressCallback | None = None) -> bool:
        """Render one frame; return whether there was one.

        `progress` may raise `Interrupted` to give the film up.
        """
        film = self._film
        if film is None:
            return False
        shot = film.shots.shot(film.done_count, film.renderer.scene.camera)
        try:
            result = film.renderer.render(
                ["display"], camera=shot.camera, seconds=shot.seconds, progress=progress
            )
            frame = picture_of("display", result.whole().images["display"])[:, :, :3]
            film.writer.add(frame)
            film.done_count += 1
            if film.done_count == film.shots.length:
                film.writer.finish()
        except Interrupted:
            self.give_up()
            return True
        except OutputError as error:
            self.give_up()
            self._viewer.say(str(error), is_fault=True)
            return True
        self._viewer.show_picture(frame)
        done, count = film.done_count, film.shots.length
        seconds = (time.monotonic() - film.began) / done
        left = datetime.timedelta(seconds=round(seconds * (count - done)))
        text = f"film: {done} of {count} frames, {left} left   (Esc gives up)"
        if done == count:
            film.renderer.release()
            self._film = None
            text = f"wrote {film.out.name}"
        self._viewer.say(text, key=_KEY)
        return True

    def give_up(self) -> None:
        """Leave no trace of the film in the making, if there is one."""
        if self._film is not None:
            self._film.writer.discard()
            self._film.renderer.release()
            self._film = None
            self._viewer.say("film given up; nothing was written", key=_KEY)
