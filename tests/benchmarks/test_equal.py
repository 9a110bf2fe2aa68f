"""Families at equal time and error; the first report's table."""

from __future__ import annotations

import math

import pytest
from bench.fake_renderer import FakeRenderer

from benchmarks import report_table
from benchmarks.equal import Curve, compare, curve_of
from ssdo_gl.settings import Settings

BASE = Settings(size=(64, 48), radius=0.3, exposure=0.0)


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


def test_the_report_normalised_what_it_should_not():
    # 5820 ms at 1024 samples, 39 ms of them fixed; printed was 5820 * 16 / 1024 = 91.
    assert report_table.report_normalised(5820, 0, 1024) == pytest.approx(91, abs=0.5)
    assert report_table.report_normalised(5820, 39, 1024) == pytest.approx(129.3, abs=0.1)


def test_fixed_and_growing_cost_are_told_apart():
    methods = [m for m in report_table.ROWS if not m.settings["method"].startswith("ref")]
    rows = {row.method.name: row for row in report_table.measure(FakeRenderer(), BASE, methods)}
    paper = rows["SSDO and bounce, paper's, 1024 reads"]
    pixels = 64 * 48 / 1e4
    assert paper.fixed_ms == pytest.approx(pixels)
    assert paper.per_sample_ms == pytest.approx(0.1 * pixels)
    assert paper.normal_ms == pytest.approx(pixels * 2.6)
    assert math.isnan(rows["visible surfaces (z-buffer)"].fixed_ms)


def test_every_row_of_the_report_is_a_valid_setting():
    for method in report_table.ROWS:
        settings = {"estimator": None, **method.settings}
        if method.count_field:
            settings[method.count_field] = method.count
        Settings(**settings).checked()
