"""Reports: radiance's histogram, the rate of frames, the front over this machine's times."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from window.driven_viewer import SIZE

from ssdo_gl.bench.presets import read_ladder
from ssdo_gl.settings import Settings
from ssdo_gl.window.camera import Controls
from ssdo_gl.window.panel.reports import (
    BINS_PER_STOP,
    STOPS,
    Reports,
    chart_points,
    log_position,
    radiance_histogram,
)

pytest.importorskip("imgui_bundle")


def test_histogram_counts_stops() -> None:
    image = np.zeros((4, 4, 4), np.float32)
    image[:2, :, :3] = 1.0
    image[2, :, :3] = 2.0**-20
    image[:3, :, 3] = 1.0
    histogram = radiance_histogram(image)
    assert len(histogram) == (STOPS[1] - STOPS[0]) * BINS_PER_STOP
    assert histogram.sum() == pytest.approx(1.0)
    assert histogram[int(-STOPS[0]) * BINS_PER_STOP] == pytest.approx(2 / 3)
    assert histogram[0] == pytest.approx(1 / 3)


def test_histogram_of_nothing_and_of_non_finite_pixels_is_empty() -> None:
    image = np.full((2, 2, 4), np.nan, np.float32)
    assert radiance_histogram(image).sum() == 0.0
    image[:, :, 3] = 1.0
    assert radiance_histogram(image).sum() == 0.0


def test_frames_between_motion_and_rest_do_not_count_as_motion(viewer) -> None:
    """They show the same view again, whose passes are kept, in a tenth of the time."""
    reports = Reports(viewer)
    # Another size is a change, which is drawn as a motion is.
    for size, milliseconds in [((32, 18), 50.0), (SIZE, 50.0), *[(SIZE, 5.0)] * 12]:
        viewer.frame(Controls(), 0.01, size)
        reports.note_frame(milliseconds)
    assert not viewer.is_resting
    assert reports.frame_rate == pytest.approx(20.0)


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
