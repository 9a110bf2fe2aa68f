"""Renders the frames of a film and encodes them, here or on a worker."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.film.numbered import frame_path
from ssdo_gl.film.shots import Shot, Shots
from ssdo_gl.gpu.held_signals import held_signals
from ssdo_gl.headless.explain import Explanation
from ssdo_gl.headless.snapshot import (
    extents_of,
    file_meta,
    missed_bounds,
    resources_wanted,
    stats_of,
)
from ssdo_gl.images.saving import Extent, image_files, picture
from ssdo_gl.render_result import RenderResult
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings


@dataclass(frozen=True)
class FilmRequest:
    """What a film is to be.

    Attributes
    ----------
    out : Path
        ``.mp4``, ``.webm``, ``.webp``, ``.gif``; a folder; or a pattern of file names
        such as ``frame_%04d.exr``.
    wanted : tuple of str
        AOV names; one alone for a film in one file.
    camera : Camera or None
        Replaces the scene's camera.
    resume : bool
        Leave the frames alone whose files exist.
    scheduler : str or None
        Where workers render it (`ssdo_gl.farm.scheduler.mapped`); None: here.
    """

    scene: Scene
    settings: Settings
    out: Path
    shots: Shots
    wanted: tuple[str, ...] = ("beauty",)
    camera: Camera | None = None
    backend: str = "auto"
    resume: bool = False
    scheduler: str | None = None
    quiet: bool = False


@dataclass(frozen=True)
class EncodedFrame:
    """A frame as it goes to files.

    Attributes
    ----------
    files : dict of Path to bytes
        Of numbered frames.
    pixels : ndarray, shape (height, width, 3), uint8, or None
        Of a film in one file; row 0 at the top.
    missed : tuple of str
        References that ended above their error bound.
    notes : tuple of str
        What there is to say of the whole film.
    is_partial : bool
        Whether it was interrupted.
    """

    index: int
    files: dict[Path, bytes] = field(default_factory=dict)
    pixels: NDArray[np.uint8] | None = None
    missed: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    is_partial: bool = False


class FrameMaker:
    """A renderer that makes the frames of a film by their number.

    Parameters
    ----------
    task : tuple of FilmRequest and Path or None
        With the pattern of the files of numbered frames; None: a film in one file.
    """

    def __init__(self, task: tuple[FilmRequest, Path | None]) -> None:
        request, self._pattern = task
        self._request = request
        self._wanted = resources_wanted(request.wanted, shows_pictures(request.out))
        self._renderer = Renderer(request.scene, request.settings, backend=request.backend)
        try:
            self._notes = _expose(self._renderer, request.shots, self._wanted, request.camera)
        except BaseException:
            self.close()
            raise

    def make(self, index: int) -> EncodedFrame:
        """Render frame `index` and encode it."""
        request, renderer = self._request, self._renderer
        _, result = _render(renderer, request.shots, self._wanted, request.camera, index)
        frame = EncodedFrame(
            index,
            missed=tuple(missed_bounds(result)),
            notes=(*request.scene.notes, *self._notes),
            is_partial=result.partial,
        )
        # What is half-way into an encoder would be lost with the rest.
        with held_signals():
            extents = extents_of(request.wanted, request.scene, result)
            if self._pattern is None:
                return dataclasses.replace(frame, pixels=self._pixels(result, extents))
            files = image_files(
                frame_path(self._pattern, index),
                request.wanted,
                result.images,
                file_meta(stats_of(renderer, Explanation(result)), result),
                extents,
            )
            return dataclasses.replace(frame, files=files)

    def _pixels(self, result: RenderResult, extents: Mapping[str, Extent]) -> NDArray[np.uint8]:
        name = self._request.wanted[0]
        pixels = picture(name, result.images, extents, alpha=False)[:, :, :3]
        return np.repeat(pixels, 3, axis=2) if pixels.shape[2] == 1 else pixels

    def close(self) -> None:
        """Free the renderer."""
        self._renderer.release()


def shows_pictures(out: Path) -> bool:
    """Return whether frames are tone-mapped, as against arrays in ``.exr`` and ``.npz``."""
    return out.suffix.lower() not in (".exr", ".npz")


def rendered_frames(
    renderer: Renderer, shots: Shots, wanted: Iterable[str], camera: Camera | None = None
) -> Iterator[tuple[Shot, RenderResult]]:
    """Yield every frame of `shots` as `renderer` draws it.

    An exposure that is measured is that of frame 0 throughout, whichever frames are drawn.
    """
    names = tuple(wanted)
    _expose(renderer, shots, names, camera)
    for index in shots.indices:
        yield _render(renderer, shots, names, camera, index)


def _render(
    renderer: Renderer, shots: Shots, names: tuple[str, ...], camera: Camera | None, index: int
) -> tuple[Shot, RenderResult]:
    shot = shots.shot(index, camera or renderer.scene.camera)
    shot = dataclasses.replace(shot, camera=shot.camera or camera)
    return shot, renderer.render(names, camera=shot.camera, seconds=shot.seconds)


def _expose(
    renderer: Renderer, shots: Shots, names: tuple[str, ...], camera: Camera | None
) -> tuple[str, ...]:
    """Measure the exposure that is left to the picture, in frame 0; return what to say of it."""
    if "display" not in names:
        return ()
    first = shots.shot(0, camera or renderer.scene.camera)
    return renderer.expose(first.camera or camera, first.seconds)
