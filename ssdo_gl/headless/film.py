"""Renders the frames of a film without a window, to one file or to many."""

from __future__ import annotations

import dataclasses
import sys
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from ssdo_gl.film.numbered import check_pattern, frame_path, frame_paths, numbered_pattern
from ssdo_gl.film.shots import Shot, Shots
from ssdo_gl.film.writers import ONE_FILE, film_writer
from ssdo_gl.gpu.held_signals import held_signals
from ssdo_gl.headless.explain import Explanation
from ssdo_gl.headless.progress import progress_on_terminal
from ssdo_gl.headless.snapshot import (
    extents_of,
    meta_without_times,
    missed_bounds,
    print_notes,
    resources_wanted,
    stats_of,
)
from ssdo_gl.images.files import OutputError
from ssdo_gl.images.saving import picture, write_images
from ssdo_gl.printable import printable
from ssdo_gl.render_result import RenderResult
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.film_options import FRAMES_PER_SECOND


@dataclass(frozen=True)
class FilmRequest:
    """What `make_film` is asked to do.

    Attributes
    ----------
    out : Path
        ``.mp4``, ``.webm``, ``.webp``, ``.gif``; a folder; or a pattern of file names
        such as ``frame_%04d.exr``.
    shots : Shots
    wanted : tuple of str
        AOV names; one alone for a film in one file.
    camera : Camera or None
        Replaces the scene's camera.
    resume : bool
        Leave the frames alone whose files exist.
    """

    scene: Scene
    settings: Settings
    out: Path
    shots: Shots
    wanted: tuple[str, ...] = ("beauty",)
    camera: Camera | None = None
    backend: str = "auto"
    resume: bool = False
    quiet: bool = False


def shows_pictures(out: Path) -> bool:
    """Return whether frames are tone-mapped, as against arrays in ``.exr`` and ``.npz``."""
    return out.suffix.lower() not in (".exr", ".npz")


def check_film(out: Path, wanted: tuple[str, ...], *, resume: bool = False) -> None:
    """Raise OutputError unless `out` can hold the film that is asked for."""
    pattern = numbered_pattern(out, ONE_FILE)
    if pattern is not None:
        check_pattern(pattern, wanted)
        return
    if resume:
        raise OutputError(
            f"{out}: --resume needs frames in files of their own: a folder, or frame_%04d.png"
        )
    if len(wanted) > 1:
        raise OutputError(f"{out}: one image fits a film, not {len(wanted)} (--aov)")
    film_writer(out, FRAMES_PER_SECOND).discard()


@dataclass(frozen=True)
class FilmOutcome:
    """What came of a film: frames that were rendered, and those above ``--max-error``."""

    rendered_count: int
    missed_count: int


def make_film(request: FilmRequest) -> FilmOutcome:
    """Render the frames that are asked for.

    Raises
    ------
    KeyboardInterrupt
        Saying what is there: the frames until then, in a film that plays or as whole files.
    OutputError
    """
    check_film(request.out, request.wanted, resume=request.resume)
    store = _store(request)
    start = time.perf_counter()
    indices = [n for n in request.shots.indices if not (request.resume and store.has(n))]
    done = missed = 0
    try:
        with (
            Renderer(request.scene, request.settings, backend=request.backend) as renderer,
            progress_on_terminal(quiet=request.quiet) as progress,
        ):
            wanted = resources_wanted(request.wanted, shows_pictures(request.out))
            notes = _expose(renderer, request.shots, wanted, request.camera) if indices else ()
            if not request.quiet:
                print_notes((*request.scene.notes, *notes))
            frames = rendered_frames(renderer, request.shots, wanted, request.camera, indices)
            for shot, result in frames:
                if result.partial:
                    raise KeyboardInterrupt
                # What is half-way into a file or an encoder would be lost with the rest.
                with held_signals():
                    store.add(shot.index, renderer, result)
                    done += 1
                missed += _say_missed(shot, result)
                if progress:
                    progress("frames", done, len(indices))
    except (KeyboardInterrupt, SystemExit) as error:
        with held_signals():
            store.finish()
        if isinstance(error, KeyboardInterrupt):
            raise KeyboardInterrupt(
                f"interrupted; {request.out} has {done} of the {len(indices)} frames"
                if done
                else "interrupted; nothing was written"
            ) from None
        raise
    except BaseException:
        store.discard()
        raise
    with held_signals():
        store.finish()
    if not request.quiet:
        _print_summary(request, len(indices), time.perf_counter() - start)
    return FilmOutcome(len(indices), missed)


def _say_missed(shot: Shot, result: RenderResult) -> bool:
    """Name each reference of a frame above its error bound; return whether there is one."""
    lines = missed_bounds(result)
    for line in lines:
        print(f"ssdo-gl: frame {shot.index}: {line}", file=sys.stderr)
    return bool(lines)


def _print_summary(request: FilmRequest, count: int, seconds: float) -> None:
    width, height = request.settings.size
    kept = len(request.shots.indices) - count
    there = f" ({kept} were there)" if kept else ""
    print(
        f"{printable(str(request.out))}: {count} frames{there}, {width}x{height}, "
        f"{request.settings.method}, {seconds:.1f} s"
    )


def rendered_frames(
    renderer: Renderer,
    shots: Shots,
    wanted: Iterable[str],
    camera: Camera | None = None,
    indices: Iterable[int] | None = None,
) -> Iterator[tuple[Shot, RenderResult]]:
    """Yield every frame of `shots`, or those of `indices`, as `renderer` draws it.

    An exposure that is measured is that of frame 0 throughout, whichever frames are drawn.
    """
    names = tuple(wanted)
    _expose(renderer, shots, names, camera)
    for index in shots.indices if indices is None else indices:
        shot = shots.shot(index, camera or renderer.scene.camera)
        shot = dataclasses.replace(shot, camera=shot.camera or camera)
        yield shot, renderer.render(names, camera=shot.camera, seconds=shot.seconds)


def _expose(
    renderer: Renderer, shots: Shots, names: tuple[str, ...], camera: Camera | None
) -> tuple[str, ...]:
    """Measure the exposure that is left to the picture, in frame 0; return what to say of it."""
    if "display" not in names:
        return ()
    first = shots.shot(0, camera or renderer.scene.camera)
    return renderer.expose(first.camera or camera, first.seconds)


class _Store(Protocol):
    """Where rendered frames go."""

    def has(self, index: int) -> bool:
        """Return whether a frame is there already."""

    def add(self, index: int, renderer: Renderer, result: RenderResult) -> None:
        """Keep a frame."""

    def finish(self) -> None:
        """Put under its name what has been added."""

    def discard(self) -> None:
        """Forget what is not under its name yet."""


def _store(request: FilmRequest) -> _Store:
    pattern = numbered_pattern(request.out, ONE_FILE)
    if pattern is None:
        return _OneFile(request)
    return _NumberedFiles(request, pattern)


class _NumberedFiles:
    """Frames as ``--snapshot`` writes them; each is there whole, or not."""

    def __init__(self, request: FilmRequest, pattern: Path) -> None:
        self._request = request
        self._pattern = pattern

    def has(self, index: int) -> bool:
        paths = frame_paths(self._pattern, index, self._request.wanted)
        return all(path.exists() for path in paths)

    def add(self, index: int, renderer: Renderer, result: RenderResult) -> None:
        out = frame_path(self._pattern, index)
        out.parent.mkdir(exist_ok=True)
        names = self._request.wanted
        meta = meta_without_times(stats_of(renderer, Explanation(result)))
        extents = extents_of(names, self._request.scene, result)
        write_images(out, names, result.images, meta, extents)

    def finish(self) -> None:
        pass

    def discard(self) -> None:
        pass


class _OneFile:
    def __init__(self, request: FilmRequest) -> None:
        self._request = request
        self._writer = film_writer(request.out, request.shots.fps)

    def has(self, index: int) -> bool:
        return False

    def add(self, index: int, renderer: Renderer, result: RenderResult) -> None:
        names = self._request.wanted
        extents = extents_of(names, self._request.scene, result)
        pixels = picture(names[0], result.images, extents, alpha=False)[:, :, :3]
        if pixels.shape[2] == 1:
            pixels = np.repeat(pixels, 3, axis=2)
        self._writer.add(pixels)

    def finish(self) -> None:
        self._writer.finish()

    def discard(self) -> None:
        self._writer.discard()
