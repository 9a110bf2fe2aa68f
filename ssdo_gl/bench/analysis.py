"""From measurements to statements: intervals, Pareto fronts, how sure they are."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.bench.measure import ErrorPanel, Judged, Point, Scalars, TimeTable, error_panels
from ssdo_gl.bench.statistics import (
    REPLICA_COUNT,
    Interval,
    bias_interval,
    draw,
    median_replicas,
    membership,
    pareto_front,
    percentile_interval,
    rmse_of,
    rmse_replicas,
)


@dataclass(frozen=True)
class Timing:
    """What one point costs; milliseconds, drift divided out.

    `ms` is by the clock of the bench, `frame_ms` by the wall clock, `process_ms` the
    processor time of all threads.
    """

    ms: Interval
    frame_ms: Interval
    process_ms: Interval
    setup_ms: float


@dataclass(frozen=True)
class Verdict:
    """One point in one panel.

    Attributes
    ----------
    error : Interval
        In the panel's unit.
    bias : Interval
        Mean signed error; in the panel's unit.
    on_front : bool
        Whether nothing measured is faster and more accurate.
    confidence : float
        In which share of the bootstrap replicas it is on the front.
    """

    error: Interval
    bias: Interval
    scalars: Scalars
    on_front: bool
    confidence: float


@dataclass(frozen=True)
class Result:
    """One point with all that is known of it."""

    point: Point
    timing: Timing
    verdicts: dict[str, Verdict]


@dataclass(frozen=True)
class ReferenceSummary:
    """What a panel's reference is worth.

    Attributes
    ----------
    standard_error : float
        Root mean square over pixels, in the panel's unit.
    smallest_error : float
        The smallest error reported against it.
    floor : float
        What is left of the error when the screen-space march has converged: what the
        screen does not show, and shadow maps. NaN where it was not measured.
    floor_parts : dict of str to float
        The same for each part of the picture, relative to the part's own mean.
    """

    panel: str
    method: str
    spp: int
    batches: int
    seconds: float
    standard_error: float
    smallest_error: float
    floor: float
    floor_parts: dict[str, float] = field(default_factory=dict)

    @property
    def ratio(self) -> float:
        """The reference's standard error over the smallest error reported."""
        if self.smallest_error > 0.0:
            return self.standard_error / self.smallest_error
        return math.inf if self.standard_error > 0.0 else 0.0


def analyse(
    points: Sequence[Point],
    table: TimeTable,
    judged: Mapping[str, Mapping[str, Judged]],
    *,
    replicas: int = REPLICA_COUNT,
) -> list[Result]:
    """Return every point with intervals, fronts and confidences.

    Parameters
    ----------
    judged : mapping
        Point key -> panel name -> measurement.
    """
    rng = np.random.default_rng(0)
    times = median_replicas(table.ms, replicas, rng)

    def interval(row: NDArray[np.float64], drawn: NDArray[np.float64]) -> Interval:
        return percentile_interval(float(np.median(row)), drawn)

    frame = median_replicas(table.frame_ms, replicas, rng)
    process = median_replicas(table.process_ms, replicas, rng)
    timings = [
        Timing(
            interval(table.ms[i], times[:, i]),
            interval(table.frame_ms[i], frame[:, i]),
            interval(table.process_ms[i], process[:, i]),
            float(table.setup_ms[i]),
        )
        for i in range(len(points))
    ]
    verdicts: list[dict[str, Verdict]] = [{} for _ in points]
    for panel in error_panels():
        members = [i for i, p in enumerate(points) if panel.name in judged.get(p.key, {})]
        if not members:
            continue
        entries = [judged[points[i].key][panel.name] for i in members]
        typical = [timings[i].ms.value for i in members]
        for i, verdict in zip(
            members, _verdicts(panel, entries, typical, times[:, members], rng), strict=True
        ):
            verdicts[i][panel.name] = verdict
    return [
        Result(point, timing, verdict)
        for point, timing, verdict in zip(points, timings, verdicts, strict=True)
    ]


def _verdicts(
    panel: ErrorPanel,
    entries: Sequence[Judged],
    typical_ms: Sequence[float],
    time_replicas: NDArray[np.float64],
    rng: np.random.Generator,
) -> list[Verdict]:
    """Return the verdicts of one panel's points, which share their bootstrap draws."""
    seeds = max(entry.blocks.seed_count for entry in entries)
    draws = draw(entries[0].blocks.block_count, seeds, len(time_replicas), rng)
    error_replicas = np.stack(
        [rmse_replicas(entry.blocks, draws, relative=panel.relative) for entry in entries],
        axis=1,
    )
    errors = [
        percentile_interval(rmse_of(entry.blocks, relative=panel.relative), error_replicas[:, i])
        for i, entry in enumerate(entries)
    ]
    front = set(pareto_front(typical_ms, [error.value for error in errors]).tolist())
    shares = membership(time_replicas, error_replicas)
    result = []
    for i, entry in enumerate(entries):
        blocks = entry.blocks
        level = float(blocks.reference.sum() / max(blocks.pixels.sum(), 1.0))
        unit = level if panel.relative and level > 0.0 else 1.0
        bias = bias_interval(blocks, draws)
        result.append(
            Verdict(
                errors[i],
                Interval(bias.value / unit, bias.low / unit, bias.high / unit),
                entry.scalars,
                i in front,
                float(shares[i]),
            )
        )
    return result


def front_of(results: Sequence[Result], panel: str) -> list[Result]:
    """Return the members of a panel's front, fastest first."""
    members = [r for r in results if panel in r.verdicts and r.verdicts[panel].on_front]
    return sorted(members, key=lambda result: result.timing.ms.value)


@dataclass(frozen=True)
class Recommendation:
    """What to take and why, in one line each."""

    result: Result | None
    sentence: str


def recommend(results: Sequence[Result], panel: str = "near") -> Recommendation:
    """Return the most efficient member of a front.

    Efficiency is 1 / (time x error^2), as is usual for Monte Carlo: halving an error by
    more samples costs four times the time, so a member is preferred if it does better
    than more samples would.
    """
    front = [
        r
        for r in front_of(results, panel)
        if r.verdicts[panel].error.value > 0.0 and r.timing.ms.value > 0.0
    ]
    if not front:
        return Recommendation(None, "nothing measured can be recommended")
    best = front[-1]
    chosen = min(front, key=lambda r: r.timing.ms.value * r.verdicts[panel].error.value ** 2)
    error = chosen.verdicts[panel].error
    sentence = (
        f"take {chosen.point.label}: {chosen.timing.ms.value:.1f} ms a frame, error "
        f"{percent(error.value)} of the mean [{percent(error.low)}, {percent(error.high)}]"
    )
    if best is not chosen:
        ratio = best.timing.ms.value / chosen.timing.ms.value
        sentence += (
            f"; the most accurate ({best.point.label}) takes {ratio:.1f} times as long "
            f"for {percent(best.verdicts[panel].error.value)}"
        )
    return Recommendation(chosen, sentence)


def percent(share: float) -> str:
    """Return a share with three digits as a person writes it."""
    return f"{three_digits(100 * share)} %"


def three_digits(value: float) -> str:
    """Return a number with three digits, and of a thousand and more all: 1340, not 1.34e+03."""
    return f"{value:.0f}" if 999.5 <= abs(value) < 1e7 else f"{value:.3g}"


def sureness(share: float) -> str:
    """Return how sure something is, as a whole percentage."""
    return f"{100 * share:.0f} %"


def as_row(result: Result) -> dict[str, Any]:
    """Return one line of ``points.csv``: everything known of a point, flat."""
    point, timing = result.point, result.timing
    row: dict[str, Any] = {
        "key": point.key,
        "label": point.label,
        "kind": point.kind,
        "family": point.family,
        "method": point.method,
        "estimator": point.estimator or "",
        "samples": point.samples if point.estimator else "",
        "steps": point.steps if point.estimator else "",
        "resolution_scale": point.resolution_scale,
        "filter": point.filter,
        "radius_factor": point.radius_factor,
        "setup_ms": round(timing.setup_ms, 2),
    }
    for name in ("ms", "frame_ms", "process_ms"):
        row |= _cells(name, getattr(timing, name))
    for panel in error_panels():
        verdict = result.verdicts.get(panel.name)
        prefix = panel.name
        row |= _cells(f"{prefix}_error", verdict.error if verdict else None)
        row |= _cells(f"{prefix}_bias", verdict.bias if verdict else None)
        scalars = verdict.scalars if verdict else Scalars()
        for name in ("noise", "systematic", "own_bias", "rel_mse", "ssim", "flip_ldr", "flip_hdr"):
            value = getattr(scalars, name)
            row[f"{prefix}_{name}"] = "" if math.isnan(value) else f"{value:.6g}"
        for part in panel.parts:
            value = scalars.parts.get(part, math.nan)
            row[f"{prefix}_{part}_error"] = "" if math.isnan(value) else f"{value:.6g}"
        row[f"{prefix}_failures"] = scalars.failures if verdict else ""
        row[f"{prefix}_front"] = int(verdict.on_front) if verdict else ""
        row[f"{prefix}_front_confidence"] = f"{verdict.confidence:.3f}" if verdict else ""
    return row


def _cells(name: str, interval: Interval | None) -> dict[str, str]:
    values = (interval.value, interval.low, interval.high) if interval else None
    return {
        column: f"{values[i]:.6g}" if values else ""
        for i, column in enumerate((name, f"{name}_low", f"{name}_high"))
    }
