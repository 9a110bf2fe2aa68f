"""The alarm for values that are not finite."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.window.live.non_finite_watch import Alarm, NonFiniteWatch

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
