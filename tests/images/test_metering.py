"""Exposure measured from pictures whose right answer is known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from ssdo_gl.images.metering import measured_exposure


def picture(*greys: float) -> NDArray[np.float32]:
    """Return a picture of equal shares of grey, covered everywhere."""
    image = np.ones((4, len(greys), 4), np.float32)
    image[..., :3] = np.asarray(greys, np.float32)[None, :, None]
    return image


@pytest.mark.parametrize("level", [1e-6, 0.01, 0.35, 1.0, 1e6])
def test_an_even_grey_comes_to_its_target(level: float) -> None:
    # Rounded to a tenth of an EV.
    expected = np.log2(0.35 / level)
    assert measured_exposure(picture(level)) == pytest.approx(expected, abs=0.051)


@given(st.floats(-20.0, 20.0))
def test_it_undoes_the_strength_of_the_light(stops: float) -> None:
    image = picture(0.05, 0.1, 0.4, 0.5)
    brighter = image * np.float32(2.0**stops)
    brighter[..., 3] = 1.0
    change = measured_exposure(image) - measured_exposure(brighter)
    assert change == pytest.approx(stops, abs=0.11)


def test_highlights_keep_their_shapes() -> None:
    # A tenth of the picture is 100 times as bright as the rest: it must come to 1.
    exposure = measured_exposure(picture(*[0.01] * 9, 1.0))
    assert 2.0**exposure == pytest.approx(1.0, rel=0.05)


def test_what_is_black_or_not_there_says_nothing() -> None:
    assert measured_exposure(picture(0.0)) == 0.0
    behind = picture(5.0)
    behind[..., 3] = 0.0
    assert measured_exposure(behind) == 0.0
    poisoned = picture(0.35, 0.35)
    poisoned[0, 0, 0] = np.nan
    assert measured_exposure(poisoned) == 0.0


def test_within_its_slack_exposure_is_left_alone() -> None:
    # 0.35 / 5: 2.3 stops below the target, of which 1.5 are granted.
    assert measured_exposure(picture(0.35 / 5), slack=1.5) == pytest.approx(0.8)
    assert measured_exposure(picture(0.35 / 2), slack=1.5) == 0.0
    assert measured_exposure(picture(0.9), slack=1.5) == 0.0
    # However dark a thing is, the grey of the ground under it is not to become white.
    assert measured_exposure(picture(1e-3), slack=1.5, most=1.0) == 1.0
    # White-out is not.
    assert measured_exposure(picture(2.0), slack=3.0) == pytest.approx(-1.0)
