"""The error while two pictures are compared, its noise, and values that are not finite."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.window.live.monitor import Alarm, NonFiniteWatch, noise_within, relative_rms


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


SIZE = (64, 36)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize(("x", "y"), [(0, 0), (63, 35), (17, 20)])
def test_alarm_finds_a_single_bad_pixel(gl, device, shaders, bad: float, x: int, y: int) -> None:
    image = np.random.default_rng(1).random((SIZE[1], SIZE[0], 4), np.float32)
    image[3, 3] = 3e38
    watch = NonFiniteWatch(device, shaders)
    texture = make_texture(gl, SIZE, 4, "f4", image[::-1])
    assert watch.check(texture) is None
    image[y, x, 2] = bad
    texture = make_texture(gl, SIZE, 4, "f4", image[::-1])
    alarm = watch.check(texture)
    assert alarm is not None
    assert alarm.count == 1
    assert alarm.pixel[0] <= x < alarm.pixel[0] + 16
    assert alarm.pixel[1] <= y < alarm.pixel[1] + 16
    watch.release()


def test_alarm_counts_pixels_and_works_on_one_channel(gl, device, shaders) -> None:
    image = np.zeros((33, 47, 1), np.float32)
    image[5:9, 7:12] = np.nan
    watch = NonFiniteWatch(device, shaders)
    assert watch.check(make_texture(gl, (47, 33), 1, "f4", image[::-1])) == Alarm(20, (0, 1))
    watch.release()
