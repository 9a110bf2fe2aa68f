"""The error that the window shows while two pictures are compared."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.window.live.monitor import relative_rms


def test_relative_rms_is_over_covered_pixels() -> None:
    reference = np.full((2, 2, 3), 2.0)
    image = reference + [[[0.2], [-0.2]], [[9.0], [9.0]]]
    covered = np.array([[True, True], [False, False]])
    assert relative_rms(image, reference, covered) == pytest.approx(0.1)


def test_relative_rms_leaves_out_what_is_not_finite() -> None:
    reference = np.full((1, 2, 3), 2.0)
    image = reference.copy()
    image[0, 0, 1] = np.nan
    covered = np.ones((1, 2), bool)
    assert relative_rms(image, reference, covered) == 0.0
    assert relative_rms(np.full_like(reference, np.nan), reference, covered) is None


def test_relative_rms_of_nothing_is_unknown() -> None:
    zero = np.zeros((2, 2, 3))
    assert relative_rms(zero, zero, np.zeros((2, 2), bool)) is None
    assert relative_rms(zero, zero, np.ones((2, 2), bool)) is None
