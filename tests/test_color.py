"""The sRGB curve against its definition."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.color import linear_from_srgb, srgb_from_linear


def test_srgb_round_trip_and_known_values():
    values = np.linspace(0.0, 1.0, 1001)
    # IEC 61966-2-1 rounds its constants: the two branches meet within 1e-7 only.
    assert linear_from_srgb(srgb_from_linear(values)) == pytest.approx(values, abs=1e-6)
    assert srgb_from_linear(np.array([0.0, 0.2140, 1.0])) == pytest.approx(
        [0.0, 0.5, 1.0], abs=1e-3
    )
