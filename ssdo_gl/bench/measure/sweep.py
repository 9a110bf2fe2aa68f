"""Times every point of a sweep: warm, interleaved in random order, resumable.

A machine's speed drifts: clocks change, other programs come and go. Each round measures
every point once in an order of its own, so drift hits all points alike; what slowed a
whole round down is then estimated from all its points and divided out.
"""

from __future__ import annotations

import csv
import dataclasses
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.bench.measure.bench_renderer import BenchRenderer
from ssdo_gl.bench.measure.machine import CLOCKS
from ssdo_gl.bench.measure.points import Point
from ssdo_gl.bench.storage import append_line, whole_lines
from ssdo_gl.graph.render_pass import ProgressCallback
from ssdo_gl.settings import Settings

# A visit of more than a week is a damaged line.
MAX_MS = 1e9
_COLUMNS = ("round", "point", "frame_ms", "process_ms", "gpu_ms", "setup_ms")


def order(round_number: int, count: int) -> list[int]:
    """Return the order, seeded, in which one round visits `count` points."""
    return [int(index) for index in np.random.default_rng([0, round_number]).permutation(count)]


@dataclass(frozen=True)
class Visit:
    """One visit to one point; times in milliseconds."""

    round: int
    point: str
    frame_ms: float
    process_ms: float
    gpu_ms: float
    setup_ms: float


def read_rows(path: Path) -> list[Visit]:
    """Return the visits recorded in `path`; lines that are not visits are left out."""
    rows = []
    for line in whole_lines(path):
        try:
            number, point, *times = next(csv.reader([line]))
            row = Visit(int(number), point, *map(float, times))
        except (ValueError, TypeError, StopIteration, csv.Error):
            continue
        # Without time queries `gpu_ms` is NaN.
        if all(0.0 <= time < MAX_MS for time in (row.frame_ms, row.process_ms, row.setup_ms)):
            rows.append(row)
    return rows


def _times(row: Visit) -> tuple[float, ...]:
    return row.frame_ms, row.process_ms, row.gpu_ms, row.setup_ms


def _line(cells: Sequence[object]) -> str:
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator="").writerow(cells)
    return buffer.getvalue()


def time_points(
    renderer: BenchRenderer,
    points: Sequence[Point],
    base: Settings,
    rounds: int,
    frames: int,
    path: Path,
    report: ProgressCallback | None = None,
) -> list[Visit]:
    """Visit every point in every round, and return all visits.

    Parameters
    ----------
    rounds, frames : int
        Visits to every point, and warm frames in each, whose median counts.
    path : Path
        A CSV file. Visits that it already records are not made again, so an
        interrupted sweep goes on where it stopped.
    """
    rows = read_rows(path)
    if not rows:
        append_line(path, _line(_COLUMNS))
    done = {(row.round, row.point) for row in rows}
    total = rounds * len(points)
    finished = sum((r, p.key) in done for r in range(rounds) for p in points)
    for number in range(rounds):
        for index in order(number, len(points)):
            point = points[index]
            if (number, point.key) in done:
                continue
            times = renderer.timed(point.settings(base), point.wanted, frames)
            row = Visit(number, point.key, **dataclasses.asdict(times))
            rows.append(row)
            append_line(path, _line([number, point.key, *(f"{t:.4f}" for t in _times(row))]))
            finished += 1
            if report is not None:
                report("timing", finished, total)
    return rows


@dataclass(frozen=True, eq=False)
class TimeTable:
    """Times of points (rows) in rounds (columns), milliseconds, drift divided out.

    Attributes
    ----------
    ms : ndarray, shape (points, rounds)
        By the clock of the bench.
    frame_ms, process_ms : ndarray, shape (points, rounds)
        By the wall clock and in processor time.
    drift : ndarray, shape (rounds,)
        By how much each round was slower than usual, by the clock; 1 is usual.
    setup_ms : ndarray, shape (points,)
        The first frame of the first visit.
    """

    ms: NDArray[np.float64]
    frame_ms: NDArray[np.float64]
    process_ms: NDArray[np.float64]
    drift: NDArray[np.float64]
    setup_ms: NDArray[np.float64]


def tabulate(
    rows: Sequence[Visit], points: Sequence[Point], rounds: int, clock: str = "wall"
) -> TimeTable:
    """Arrange visits as a table.

    Raises
    ------
    KeyError
        If a visit is missing, or there is no such clock.
    """
    by_place = {(row.point, row.round): row for row in rows}
    table = [[by_place[point.key, number] for number in range(rounds)] for point in points]

    def times(field: str) -> NDArray[np.float64]:
        return np.array([[getattr(row, field) for row in line] for line in table])

    chosen, frame, process = times(CLOCKS[clock]), times("frame_ms"), times("process_ms")
    drift = round_drift(chosen)
    return TimeTable(
        chosen / drift,
        frame / round_drift(frame),
        process / round_drift(process),
        drift,
        np.array([line[0].setup_ms for line in table]),
    )


def round_drift(times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how slow each round was: the median over points of time / usual time.

    With t = cost of the point x speed of the round x noise, the median over many points
    estimates the speed; a point that happened to be disturbed does not move it.
    """
    usual = np.median(times, axis=1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(usual > 0.0, times / usual, 1.0)
    drift = np.median(ratio, axis=0)
    return np.asarray(np.where(drift > 0.0, drift, 1.0))
