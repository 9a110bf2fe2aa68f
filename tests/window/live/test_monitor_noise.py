"""How much of a running error is noise follows from how it falls."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ssdo_gl.window.live.monitor import noise_within


@pytest.mark.parametrize(("left", "right"), [((4, 16), (8, 16)), ((16, 8), (16, 64))])
def test_what_is_left_at_last_is_told_from_two_measurements(left, right):
    bias, variance = 0.04, 0.3

    def measured(counts):
        share = sum(1.0 / count for count in counts)
        return share, math.sqrt(bias + variance * share)

    before, now = measured(left), measured(right)
    assert now[1] - noise_within(before, now) == pytest.approx(math.sqrt(bias))


def test_an_error_that_no_longer_falls_is_certain():
    assert noise_within((0.5, 0.2), (0.25, 0.2)) == 0.0


def test_an_error_that_is_all_noise_is_wholly_uncertain():
    assert noise_within((0.5, 0.2 * math.sqrt(2.0)), (0.25, 0.2)) == pytest.approx(0.2)


def test_pictures_of_noise_are_within_it():
    """Two images that differ by .1 in expectation, of samples whose deviation is .5."""
    rng = np.random.default_rng(3)
    samples = 0.5 * rng.standard_normal((64, 4000))

    def measured(count):
        difference = 0.1 + samples[:count].mean(axis=0)
        return 1.0 / count, float(np.sqrt(np.mean(difference**2)))

    for count in (4, 8, 16, 32):
        before, now = measured(count), measured(2 * count)
        assert now[1] - noise_within(before, now) == pytest.approx(0.1, abs=0.03)
