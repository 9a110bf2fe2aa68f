"""Times every point of a sweep: warm, interleaved in random order.

A machine's speed drifts: clocks change, other programs come and go. Each round measures
every point once in an order of its own, so drift hits all points alike; what slowed a
whole round down is then estimated from all its points and divided out.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.bench.measure.bench_renderer import BenchRenderer
from ssdo_gl.bench.measure.machine import CLOCKS
from ssdo_gl.bench.measure.points import Point
from ssdo_gl.graph.render_pass import ProgressCallback
from ssdo_gl.settings import Settings


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


def time_points(
    renderer: BenchRenderer,
    points: Sequence[Point],
    base: Settings,
    rounds: int,
    frames: int,
    report: ProgressCallback | None = None,
) -> list[Visit]:
    """Visit every point in every round, and return all visits.

    Parameters
    ----------
    rounds, frames : int
        Visits to every point, and warm frames in each, whose median counts.
    """
    rows = []
    for number in range(rounds):
        for index in order(number, len(points)):
            point = points[index]
            times = renderer.timed(point.settings(base), point.wanted, frames)
            rows.append(Visit(number, point.key, **dataclasses.asdict(times)))
            if report is not None:
                report("timing", len(rows), rounds * len(points))
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
