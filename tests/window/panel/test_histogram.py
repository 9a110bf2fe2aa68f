"""The histogram of radiance."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.window.panel.reports import BINS_PER_STOP, STOPS, radiance_histogram

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
