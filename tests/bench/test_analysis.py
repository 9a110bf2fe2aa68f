"""Statements from measurements: fronts, confidence, recommendation, CSV rows."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from bench.fake_bench import cost_ms, results

from ssdo_gl.bench import analysis
from ssdo_gl.bench.measure.errors import Judged, Scalars
from ssdo_gl.bench.measure.panels import error_panels
from ssdo_gl.bench.measure.points import Point
from ssdo_gl.bench.measure.sweep import TimeTable
from ssdo_gl.bench.statistics.bootstrap import BlockErrors


def points(count: int) -> list[Point]:
    return [
        Point("visibility", "f", "ssao", "march", 2**i, 1, 1.0, "edge") for i in range(1, count + 1)
    ]


def errors(rmse: float, spread: float = 0.0, seed: int = 0) -> Judged:
    rng = np.random.default_rng(seed)
    squared = rmse**2 * (1.0 + spread * rng.standard_normal((1, 100)))
    ones = np.ones(100)
    return Judged(BlockErrors(squared, np.zeros((1, 100)), 0.5 * ones, ones), Scalars())


def analysed(times: np.ndarray, rmse: list[float], spread: float = 0.0) -> list[analysis.Result]:
    grid = points(len(rmse))
    table = TimeTable(times, times, 2 * times, np.ones(times.shape[1]), times[:, 0])
    judged = {
        p.key: {"visibility": errors(e, spread, i)}
        for i, (p, e) in enumerate(zip(grid, rmse, strict=True))
    }
    return analysis.analyse(grid, table, judged, replicas=400)


def test_front_and_confidence():
    times = np.tile([[1.0], [2.0], [3.0], [4.0]], (1, 5))
    found = analysed(times, [0.4, 0.2, 0.3, 0.1])
    verdicts = [r.verdicts["visibility"] for r in found]
    assert [v.on_front for v in verdicts] == [True, True, False, True]
    assert [v.confidence for v in verdicts] == [1.0, 1.0, 0.0, 1.0]
    assert verdicts[0].error.value == pytest.approx(0.4)
    assert [r.timing.process_ms.value for r in found] == [2.0, 4.0, 6.0, 8.0]
    assert [r.point.samples for r in analysis.front_of(found, "visibility")] == [2, 4, 16]


def test_noise_makes_membership_unsure():
    times = np.tile([[1.0], [2.0], [3.0]], (1, 5))
    # The last two differ by 0.5 % and scatter by 5 % between blocks' means: a coin toss.
    found = analysed(times, [0.4, 0.2, 0.199], spread=0.5)
    share = [r.verdicts["visibility"].confidence for r in found]
    assert share[0] == share[1] == 1.0
    assert 0.1 < share[2] < 0.9


def test_noisy_times_make_membership_unsure():
    rng = np.random.default_rng(1)
    times = np.array([[1.0], [2.0]]) * rng.uniform(0.3, 3.0, (2, 5))
    share = [r.verdicts["visibility"].confidence for r in analysed(times, [0.2, 0.2 * 1.001])]
    assert share[0] > share[1] > 0.0


def test_the_most_efficient_member_is_recommended():
    times = np.tile([[1.0], [1.2], [10.0]], (1, 3))
    found = analysed(times, [0.5, 0.1, 0.09])
    advice = analysis.recommend(found, "visibility")
    assert advice.result is found[1]
    assert "1.2 ms" in advice.sentence
    assert "8.3 times as long" in advice.sentence


def test_half_the_error_is_worth_up_to_four_times_the_time():
    for cost, wanted in ((3.9, 1), (4.1, 0)):
        times = np.tile([[1.0], [cost]], (1, 3))
        found = analysed(times, [0.2, 0.1])
        assert analysis.recommend(found, "visibility").result is found[wanted]


def test_there_is_nothing_to_recommend_without_measurements():
    assert analysis.recommend([], "near").result is None


def test_a_failed_point_is_neither_on_the_front_nor_recommended():
    times = np.tile([[1.0], [2.0]], (1, 3))
    found = analysed(times, [math.inf, 0.1])
    assert not found[0].verdicts["visibility"].on_front
    assert found[0].verdicts["visibility"].confidence == 0.0
    assert analysis.recommend(found, "visibility").result is found[1]


def test_points_of_another_radius_are_held_to_full_transport_only():
    near, gi, visibility = error_panels()
    point = Point("radiance", "f", "bounce", "march", 64, 8, 1.0, "edge")
    assert near.judges(point)
    assert gi.judges(point)
    assert not visibility.judges(point)
    other = dataclasses.replace(point, radius_factor=2.0)
    assert not near.judges(other)
    assert gi.judges(other)


def test_rows_hold_every_number_once():
    rows = [analysis.as_row(result) for result in results()]
    assert len({tuple(row) for row in rows}) == 1, "all rows have the same columns"
    row = next(r for r in rows if r["method"] == "bounce")
    assert float(row["near_error_low"]) <= float(row["near_error"]) <= float(row["near_error_high"])
    assert row["visibility_error"] == ""
    assert float(row["near_bounce_error"]) > 0.0
    result = results()[0]
    assert float(analysis.as_row(result)["ms"]) == pytest.approx(cost_ms(result.point), rel=0.05)


def test_references_say_what_they_are_worth():
    summary = analysis.ReferenceSummary("near", "reference-near", 64, 4, 1.0, 0.004, 0.05, 0.04)
    assert summary.ratio == pytest.approx(0.08)
    assert dataclasses.replace(summary, smallest_error=0.0).ratio == math.inf
