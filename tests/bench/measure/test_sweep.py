"""Timing: order, resumption, drift."""

from __future__ import annotations

import dataclasses
import math
import random

import numpy as np
import pytest
from bench.fake_renderer import FakeRenderer, Interrupted

from ssdo_gl.bench.measure import sweep
from ssdo_gl.bench.measure.points import Point
from ssdo_gl.settings import Settings

BASE = Settings(size=(100, 100), radius=0.3)
POINTS = [
    Point("radiance", "f", "bounce", "march", samples, 8, 1.0, "edge")
    for samples in (8, 16, 32, 64)
]
ROUNDS, FRAMES = 3, 2


def test_every_round_visits_every_point_in_an_order_of_its_own():
    orders = [sweep.order(number, 20) for number in range(5)]
    assert all(sorted(order) == list(range(20)) for order in orders)
    assert len({tuple(order) for order in orders}) == 5
    assert orders == [sweep.order(number, 20) for number in range(5)], "seeded"


def test_visits_are_recorded(tmp_path):
    renderer = FakeRenderer()
    path = tmp_path / "rounds.csv"
    rows = sweep.time_points(renderer, POINTS, BASE, ROUNDS, FRAMES, path)
    assert len(rows) == 12
    assert renderer.count("timed") == 12
    kept = sweep.read_rows(path)
    assert [(row.round, row.point) for row in kept] == [(row.round, row.point) for row in rows]
    for row, other in zip(kept, rows, strict=True):
        assert row.frame_ms == pytest.approx(other.frame_ms, abs=1e-4)
        assert row.process_ms == pytest.approx(other.process_ms, abs=1e-4)
        assert row.setup_ms == pytest.approx(other.setup_ms, abs=1e-4)
        assert math.isnan(row.gpu_ms)


def test_an_interrupted_sweep_goes_on_where_it_stopped(tmp_path):
    path = tmp_path / "rounds.csv"
    first = FakeRenderer(interrupt_after=5)
    with pytest.raises(Interrupted):
        sweep.time_points(first, POINTS, BASE, ROUNDS, FRAMES, path)
    with path.open("ab") as file:
        file.write(b"1,radiance-bounce")  # what a kill in the middle of a line leaves
    second = FakeRenderer()
    seen = []
    rows = sweep.time_points(
        second,
        POINTS,
        BASE,
        ROUNDS,
        FRAMES,
        path,
        lambda _, done, total: seen.append((done, total)),
    )
    assert second.count("timed") == 12 - 5
    assert seen[0] == (6, 12)
    assert seen[-1] == (12, 12)
    keys = [(row.round, row.point) for row in rows]
    assert len(set(keys)) == len(keys) == 12
    third = FakeRenderer()
    sweep.time_points(third, POINTS, BASE, ROUNDS, FRAMES, path)
    assert third.count("timed") == 0


def test_damaged_records_are_measured_again(tmp_path):
    path = tmp_path / "rounds.csv"
    sweep.time_points(FakeRenderer(), POINTS, BASE, ROUNDS, FRAMES, path)
    data, rng = path.read_bytes(), random.Random(0)
    for _ in range(200):
        damaged = bytearray(data)
        for _ in range(3):
            damaged[rng.randrange(len(data))] = rng.randrange(256)
        path.write_bytes(damaged)
        rows = sweep.time_points(FakeRenderer(), POINTS, BASE, ROUNDS, FRAMES, path)
        table = sweep.tabulate(rows, POINTS, ROUNDS)
        assert np.isfinite(table.frame_ms).all()


def test_drift_of_whole_rounds_is_divided_out():
    cost = np.array([1.0, 2.0, 5.0, 9.0, 20.0])
    speed = np.array([1.0, 1.6, 0.9, 1.0])
    times = cost[:, None] * speed[None, :]
    times[3, 0] *= 4.0  # one disturbed visit must not move the round
    drift = sweep.round_drift(times)
    np.testing.assert_allclose(drift / drift[0], speed / speed[0], rtol=1e-12)


def test_the_table_has_a_row_for_each_point(tmp_path):
    rows = sweep.time_points(FakeRenderer(), POINTS, BASE, ROUNDS, FRAMES, tmp_path / "rounds.csv")
    table = sweep.tabulate(rows, POINTS, ROUNDS)
    costs = [FakeRenderer().cost_ms(p.settings(BASE)) for p in POINTS]
    np.testing.assert_allclose(table.frame_ms, np.array(costs)[:, None] * np.ones(3), rtol=1e-6)
    np.testing.assert_allclose(table.process_ms, 2 * table.frame_ms, rtol=1e-6)
    np.testing.assert_allclose(table.drift, 1.0)
    slow = [
        dataclasses.replace(r, frame_ms=r.frame_ms * (2.0 if r.round == 1 else 1.0)) for r in rows
    ]
    drifting = sweep.tabulate(slow, POINTS, ROUNDS)
    np.testing.assert_allclose(drifting.drift, [1.0, 2.0, 1.0])
    np.testing.assert_allclose(drifting.ms, table.frame_ms)
    np.testing.assert_allclose(drifting.frame_ms, table.frame_ms)
    other = sweep.tabulate(slow, POINTS, ROUNDS, "process")
    np.testing.assert_allclose(other.ms, table.process_ms)
    np.testing.assert_allclose(other.drift, 1.0)
    with pytest.raises(KeyError):
        sweep.tabulate(rows[1:], POINTS, ROUNDS)
