"""The measured front laid over this machine's times."""

from __future__ import annotations

import dataclasses

import pytest

from ssdo_gl.bench.presets import read_ladder
from ssdo_gl.settings import Settings
from ssdo_gl.window.panel.pareto_chart import chart_points, log_position

FRONT = [
    {"label": "a", "samples": 16, "steps": 8, "resolution_scale": 0.5}
    | {"relative_time": 0.5, "error": 0.08},
    {"label": "b", "samples": 64, "steps": 8, "resolution_scale": 1.0}
    | {"relative_time": 2.0, "error": 0.04},
]


def test_the_setting_in_use_gives_the_scale() -> None:
    points = chart_points(FRONT, Settings(samples=64, steps=8), frame_ms=10.0)
    assert [(p.label, p.frame_ms, p.error, p.is_used) for p in points] == [
        ("a", 2.5, 0.08, False),
        ("b", 10.0, 0.04, True),
    ]


def test_a_setting_beside_the_front_takes_the_scale_of_its_neighbour() -> None:
    points = chart_points(FRONT, Settings(samples=32, resolution_scale=0.5), frame_ms=5.0)
    assert [(p.frame_ms, p.is_used) for p in points] == [(5.0, False), (20.0, False)]


def test_without_measurements_there_is_no_chart() -> None:
    assert chart_points([], Settings(), 10.0) == []
    assert chart_points(FRONT, Settings(), 0.0) == []


def test_the_shipped_ladder_can_be_charted() -> None:
    rows = [{**dataclasses.asdict(rung), "label": rung.label} for rung in read_ladder().rungs]
    points = chart_points(rows, Settings(), 10.0)
    assert len(points) == len(rows)
    assert all(p.frame_ms > 0.0 and p.error > 0.0 for p in points)


def test_logarithmic_axis() -> None:
    assert log_position(1.0, 0.1, 10.0) == pytest.approx(0.5)
    assert log_position(10.0, 0.1, 10.0) == pytest.approx(1.0)
    assert log_position(3.0, 2.0, 2.0) == 0.5
