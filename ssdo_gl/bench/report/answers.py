"""Which setting to take for a time, or for an error: looked up on the measured fronts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from ssdo_gl.bench.analysis import Result
from ssdo_gl.bench.measure import ErrorPanel
from ssdo_gl.bench.statistics import pareto_front

# What the page asks for before the reader has typed anything; percent.
USUAL_MS, USUAL_PERCENT = 30.0, 5.0
# Frames a second, and errors in percent, that are answered in a table.
RATES = (60, 30, 10, 2)
PERCENTS = (20.0, 10.0, 5.0, 3.0)


@dataclass(frozen=True)
class Candidate:
    """A setting that may be the answer.

    Attributes
    ----------
    ms, error : float
        What has to be within a bound: an estimate, or the upper end of its interval.
    """

    result: Result
    ms: float
    error: float


def candidates(
    results: Sequence[Result], panel: ErrorPanel, sure_of: Literal["", "have", "bear"] = ""
) -> list[Candidate]:
    """Return the settings that no other one beats: by time, and errors fall.

    Parameters
    ----------
    sure_of : str
        Of what the upper end of the 95 % interval counts, and not the estimate: of the time
        that one has (``have``), of the error that one can bear (``bear``), or of neither.
    """
    found = []
    for result in results:
        verdict = result.verdicts.get(panel.name)
        if verdict is not None:
            ms, error = result.timing.ms, verdict.error
            pair = (
                ms.high if sure_of == "have" else ms.value,
                error.high if sure_of == "bear" else error.value,
            )
            found.append(Candidate(result, *pair))
    front = pareto_front([c.ms for c in found], [c.error for c in found])
    return [found[i] for i in front]


def most_accurate_within(front: Sequence[Candidate], ms: float) -> Candidate | None:
    """Return the member of a front that is most accurate within a time; None if none is."""
    return next((c for c in reversed(front) if c.ms <= ms), None)


def cheapest_within(front: Sequence[Candidate], error: float) -> Candidate | None:
    """Return the member of a front that is fastest within an error; None if none is."""
    return next((c for c in front if c.error <= error), None)
