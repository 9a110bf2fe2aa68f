"""Makes a film without a window: one file, or many."""

from __future__ import annotations

import sys
import time
from collections.abc import Generator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from ssdo_gl.farm.scheduler import FarmError, mapped
from ssdo_gl.film.numbered import check_pattern, frame_paths, numbered_pattern
from ssdo_gl.film.writers import ONE_FILE, FilmWriter, film_writer
from ssdo_gl.gpu.held_signals import held_signals, whole_before_ctrl_c
from ssdo_gl.headless.film_frames import EncodedFrame, FilmRequest, FrameMaker
from ssdo_gl.headless.snapshot import print_notes
from ssdo_gl.images.files import OutputError, write_atomically
from ssdo_gl.options.run_options import FRAMES_PER_SECOND
from ssdo_gl.progress import progress_on_terminal
from ssdo_gl.whole_files import has_data
from ssdo_gl.wording import counted, printable


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
    FarmError
        Saying so, too.
    OutputError
    """
    check_film(request.out, request.wanted, resume=request.resume)
    pattern = numbered_pattern(request.out, ONE_FILE)
    writer = film_writer(request.out, request.shots.fps) if pattern is None else None
    start = time.perf_counter()
    indices = _indices_to_make(request, pattern)
    done = missed = 0
    try:
        with (
            progress_on_terminal(quiet=request.quiet) as progress,
            closing(_frames(request, pattern, indices)) as frames,
        ):
            for frame in frames:
                if frame.is_partial:
                    raise KeyboardInterrupt
                if not (done or request.quiet):
                    print_notes(frame.notes)
                with held_signals():
                    _keep(frame, writer)
                    done += 1
                missed += _say_missed(frame)
                if progress:
                    progress("frames", done, len(indices))
    except (KeyboardInterrupt, SystemExit, FarmError) as error:
        with held_signals():
            if writer:
                writer.finish()
        there = f"{request.out} has {done} of the {len(indices)} frames"
        there = there if done else "nothing was written"
        if isinstance(error, KeyboardInterrupt):
            raise KeyboardInterrupt(f"interrupted; {there}") from None
        if isinstance(error, FarmError):
            raise FarmError(f"{error}; {there}") from None
        raise
    except BaseException:
        if writer:
            writer.discard()
        raise
    with whole_before_ctrl_c(f"interrupted; {request.out} has all of the {len(indices)} frames"):
        if writer:
            writer.finish()
    if not request.quiet:
        _print_summary(request, len(indices), time.perf_counter() - start)
    return FilmOutcome(len(indices), missed)


def _indices_to_make(request: FilmRequest, pattern: Path | None) -> Sequence[int]:
    """Return the frames that are asked for, without those that ``--resume`` finds."""
    if pattern is None or not request.resume:
        return request.shots.indices
    return [
        index
        for index in request.shots.indices
        if not all(has_data(path) for path in frame_paths(pattern, index, request.wanted))
    ]


def _keep(frame: EncodedFrame, writer: FilmWriter | None) -> None:
    """Append a frame to the film in one file, or write its files; each is whole, or not there."""
    if writer:
        assert frame.pixels is not None, "frames of a film in one file are pixels"
        writer.add(frame.pixels)
    for path, data in frame.files.items():
        path.parent.mkdir(exist_ok=True)
        write_atomically(path, data)


def _frames(
    request: FilmRequest, pattern: Path | None, indices: Sequence[int]
) -> Generator[EncodedFrame, None, None]:
    """Yield the frames `indices`, in their order, as they are made here or by workers."""
    if not indices:
        return
    task = request, pattern
    if request.scheduler is not None:
        yield from mapped(request.scheduler, FrameMaker, task, indices)
        return
    with closing(FrameMaker(task)) as maker:
        for index in indices:
            yield maker.make(index)


def _say_missed(frame: EncodedFrame) -> bool:
    """Name each reference of a frame above its error bound; return whether there is one."""
    for line in frame.missed:
        print(f"ssdo-gl: frame {frame.index}: {line}", file=sys.stderr)
    return bool(frame.missed)


def _print_summary(request: FilmRequest, count: int, seconds: float) -> None:
    width, height = request.settings.size
    kept = len(request.shots.indices) - count
    there = f" ({kept} were there)" if kept else ""
    print(
        f"{printable(str(request.out))}: {counted(count, 'frame')}{there}, {width}x{height}, "
        f"{request.settings.method}, {seconds:.1f} s"
    )
