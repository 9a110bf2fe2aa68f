"""Anti-aliasing averages light."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.images.average import ImageAverage


def of(value, name):
    image = np.full((2, 3, 4), value, np.float32)
    image[..., 3] = 1.0
    return {name: image}


def test_linear_images_average_as_they_are():
    average = ImageAverage()
    for value in (1.0, 2.0, 6.0):
        average.add(of(value, "beauty"))
    assert average.images()["beauty"][..., :3] == pytest.approx(3.0)
    assert average.images()["beauty"].dtype == np.float32


def test_black_and_white_make_the_code_of_half_the_light():
    average = ImageAverage()
    average.add(of(0.0, "display"))
    average.add(of(1.0, "display"))
    # sRGB code of 0.5 (IEC 61966-2-1): 1.055 * 0.5^(1/2.4) - 0.055 = 0.7354.
    assert average.images()["display"][..., :3] == pytest.approx(0.7354, abs=1e-4)
    assert (average.images()["display"][..., 3] == 1.0).all()


def test_what_is_transparent_does_not_darken_what_is_not():
    average = ImageAverage()
    clear = {"display": np.zeros((2, 3, 4), np.float32)}
    for images in (of(0.5, "display"), clear, clear, clear):
        average.add(images)
    assert average.images()["display"][..., :3] == pytest.approx(0.5, abs=1e-6)
    assert average.images()["display"][..., 3] == pytest.approx(0.25)


def test_a_single_frame_passes_unchanged():
    average = ImageAverage()
    average.add(of(0.3, "display"))
    assert np.array_equal(average.images()["display"], of(0.3, "display")["display"])
