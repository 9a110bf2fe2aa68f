"""Reports: the histogram of radiance, the rate of frames."""

from __future__ import annotations

import numpy as np
import pytest
from window.driven_viewer import SIZE

from ssdo_gl.window.camera import Controls
from ssdo_gl.window.panel.reports import BINS_PER_STOP, STOPS, Reports, radiance_histogram

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
