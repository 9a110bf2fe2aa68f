"""Families at equal time and at equal error."""

from __future__ import annotations

import math

import pytest

from benchmarks.equal import Curve, compare, curve_of


def test_families_are_compared_along_their_own_fronts():
    slow = Curve("paper", (10.0, 20.0), (0.2, 0.1), ("a", "b"))
    fast = Curve("march", (4.0, 9.0, 40.0), (0.3, 0.05, 0.01), ("c", "d", "e"))
    assert (fast.error_at(9.0), fast.error_at(8.9)) == (0.05, 0.3)
    assert (fast.time_at(0.05), fast.time_at(0.049)) == (9.0, 40.0)
    found = compare(slow, fast)
    assert found.equal_time == (("a", 10.0, 0.2, 0.05), ("b", 20.0, 0.1, 0.05))
    assert found.equal_error == (("a", 10.0, 0.2, 9.0), ("b", 20.0, 0.1, 9.0))
    assert found.error_ratio == pytest.approx(math.sqrt(0.25 * 0.5))
    assert found.time_ratio == pytest.approx(math.sqrt(0.9 * 0.45))


def test_what_cannot_be_compared_is_said_to_be_so():
    found = compare(Curve("a", (1.0,), (0.01,), ("x",)), Curve("b", (2.0,), (0.5,), ("y",)))
    assert found.equal_time[0][3] == math.inf
    assert found.equal_error[0][3] == math.inf
    assert math.isnan(found.error_ratio)
    assert math.isnan(found.time_ratio)


def test_a_curve_is_the_front_of_its_families():
    def row(family: str, ms: float, error: str) -> dict[str, str]:
        return {
            "family": family, "ms": str(ms), "near_error": error, "label": f"{family}{ms}",
        }  # fmt: skip

    rows = [row("f", 2, "0.2"), row("f", 1, "0.3"), row("f", 3, "0.25"), row("g", 1, "0.1"),
            row("f", 4, "")]  # fmt: skip
    assert curve_of(rows, "n", ("f",)).times == (1.0, 2.0)
    assert curve_of(rows, "n", ("f", "g")).times == (1.0,)
