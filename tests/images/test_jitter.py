"""Sub-pixel offsets: centred, and spread over the pixel."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.images.average import jitter


@pytest.mark.parametrize("count", [1, 2, 4, 16, 64])
def test_jitter_is_centred_and_covers_the_pixel(count):
    offsets = np.array([jitter(index, count) for index in range(count)])
    # A shift of the mean would shift the picture: float64 rounding only.
    assert np.abs(offsets.mean(axis=0)).max() < 1e-12
    for axis in range(2):
        ordered = np.sort(offsets[:, axis])
        # Three-gap theorem: no gap of a golden lattice exceeds the golden ratio
        # squared times the mean gap, and the ends lie within the pixel and half a gap.
        assert np.all(np.diff(ordered) < 2.62 / count)
        assert np.all(np.abs(ordered) <= 0.5 + 0.5 / count)
