"""Equal time, equal error: two families of settings compared along their own fronts."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ssdo_gl.bench.analysis import percent
from ssdo_gl.bench.statistics import pareto

# Families of `ssdo_gl/bench/grid.toml`.
PAPER = ("paper's ssdo, naive blur",)
MARCH = ("march, half resolution", "march, full resolution")


@dataclass(frozen=True)
class Curve:
    """The front of one family: error against time, from fast to accurate."""

    name: str
    times: tuple[float, ...]
    errors: tuple[float, ...]
    labels: tuple[str, ...]

    def error_at(self, time_ms: float) -> float:
        """Return the error that `time_ms` buys: that of the last member that fits.

        Infinite if none fits. No setting between two members is invented.
        """
        fitting = [e for t, e in zip(self.times, self.errors, strict=True) if t <= time_ms]
        return min(fitting, default=math.inf)

    def time_at(self, error: float) -> float:
        """Return the time of the first member within `error`; infinite if none is."""
        fitting = [t for t, e in zip(self.times, self.errors, strict=True) if e <= error]
        return min(fitting, default=math.inf)


def curve_of(rows: Iterable[Mapping[str, str]], name: str, families: Sequence[str]) -> Curve:
    """Return the front of the points of some families.

    Parameters
    ----------
    rows : iterable of mapping
        Lines of ``points.csv``.
    """
    chosen = [row for row in rows if row["family"] in families and row["near_error"]]
    times = [float(row["ms"]) for row in chosen]
    errors = [float(row["near_error"]) for row in chosen]
    members = pareto.pareto_front(times, errors)
    return Curve(
        name,
        tuple(times[i] for i in members),
        tuple(errors[i] for i in members),
        tuple(chosen[int(i)]["label"] for i in members),
    )


@dataclass(frozen=True)
class Comparison:
    """What the second family gains over the first.

    Attributes
    ----------
    equal_time : tuple of (label, ms, error, error of the other)
        For every member of the first curve: what the other reaches in its time.
    equal_error : tuple of (label, ms, error, ms of the other)
        For every member of the first curve: when the other reaches its error.
    """

    first: str
    second: str
    equal_time: tuple[tuple[str, float, float, float], ...]
    equal_error: tuple[tuple[str, float, float, float], ...]

    @property
    def error_ratio(self) -> float:
        """Geometric mean of (other's error / error) at equal time; NaN if never."""
        return _mean_ratio([(theirs, own) for _, _, own, theirs in self.equal_time])

    @property
    def time_ratio(self) -> float:
        """Geometric mean of (other's time / time) at equal error; NaN if never."""
        return _mean_ratio([(theirs, own) for _, own, _, theirs in self.equal_error])


def _mean_ratio(pairs: Sequence[tuple[float, float]]) -> float:
    logs = [math.log(a / b) for a, b in pairs if 0.0 < a < math.inf and 0.0 < b < math.inf]
    return math.exp(float(np.mean(logs))) if logs else math.nan


def compare(first: Curve, second: Curve) -> Comparison:
    """Hold `second` to every member of `first`, at its time and at its error."""
    members = list(zip(first.labels, first.times, first.errors, strict=True))
    return Comparison(
        first.name,
        second.name,
        tuple((label, t, e, second.error_at(t)) for label, t, e in members),
        tuple((label, t, e, second.time_at(e)) for label, t, e in members),
    )


def comparison_lines(found: Comparison) -> list[str]:
    """Return a Markdown table of one family against another."""
    other = found.second
    lines = [
        f"| {found.first} | ms | error | {other} in that time | {other} at that error, ms |",
        "|---|---|---|---|---|",
    ]
    for (label, ms, error, reached), (_, _, _, needed) in zip(
        found.equal_time, found.equal_error, strict=True
    ):
        cells = (label, f"{ms:.1f}", percent(error), _share(reached), _milliseconds(needed))
        lines.append("| " + " | ".join(cells) + " |")
    lines.append("")
    lines.append(
        f"At equal time the march has {_times(found.error_ratio)} the error; at equal error it "
        f"takes {_times(found.time_ratio)} the time (geometric means)."
    )
    return lines


def _share(value: float) -> str:
    return percent(value) if math.isfinite(value) else "nothing fits"


def _milliseconds(value: float) -> str:
    return f"{value:.1f}" if math.isfinite(value) else "never"


def _times(ratio: float) -> str:
    return "no comparable part of" if math.isnan(ratio) else f"{ratio:.2f} times"
