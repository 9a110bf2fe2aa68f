"""Frames of a film: which ones, when, and from where."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ssdo_gl.film.camera_path import CameraPath
from ssdo_gl.film.shots import Shots, frames_from_text
from ssdo_gl.scene.camera import Camera
from ssdo_gl.settings.fields import SettingError

BASE = Camera((3.0, 1.0, 1.0), (1.0, 1.0, 1.0))


def test_a_turntable_goes_round_the_target_counter_clockwise() -> None:
    # Seen from above (+y), x turns towards -z.
    assert BASE.orbit(90.0).position == pytest.approx((1.0, 1.0, -1.0))
    assert BASE.orbit(360.0).position == pytest.approx(BASE.position)
    assert BASE.orbit(90.0).target == BASE.target
    # About another up, y turns towards z.
    tilted = Camera((0.0, 2.0, 5.0), (0.0, 0.0, 0.0), up=(2.0, 0.0, 0.0))
    assert tilted.orbit(90.0).position == pytest.approx((0.0, -5.0, 2.0))


def test_the_turn_is_that_of_the_whole_film() -> None:
    part = Shots(turntable=360.0, frames=(2, 4, 8))
    assert list(part.indices) == [2, 3]
    assert part.shot(2, BASE).camera == BASE.orbit(90.0)
    assert list(Shots(turntable=90.0, fps=2.0).indices) == list(range(16))


def test_a_path_gives_its_length_and_cameras() -> None:
    far = Camera((9.0, 1.0, 1.0), (1.0, 1.0, 1.0))
    path = CameraPath().recorded(0.0, BASE).recorded(1.5, far)
    shots = Shots(path, fps=4.0, start_s=10.0)
    assert shots.length == 6
    shot = shots.shot(3, BASE)
    assert shot.seconds == 10.75 and shot.camera == path.camera(0.75, BASE)


def test_without_path_and_turntable_the_scene_moves_alone() -> None:
    shots = Shots(frames=(0, 3))
    assert shots.length == 3
    assert shots.shot(2, BASE).camera is None
    assert shots.shot(2, BASE).seconds == pytest.approx(2 / 30)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({}, "needs its length"),
        ({"turntable": 1.0, "path": CameraPath()}, "give one of them"),
        ({"turntable": 1.0, "fps": 0.0}, "fps = 0.0"),
        ({"turntable": 1.0, "fps": math.nan}, "fps = nan"),
        ({"turntable": 1.0, "fps": "30"}, "fps = '30': expected a finite number"),
        ({"turntable": math.nan}, "turntable = nan"),
        ({"turntable": 1.0, "start_s": math.inf}, "time = inf"),
        ({"turntable": 1.0, "frames": (0, 2.5, 3)}, "frames = .*: expected whole numbers"),
        ({"turntable": 1.0, "frames": (3, 3, 3)}, "frames .* <= length <= 5000000"),
        ({"turntable": 1.0, "frames": (-1, 3, 3)}, "frames"),
        ({"turntable": 1.0, "frames": (5, 2)}, r"frames = \(5, 2\): expected 0 <= first < end"),
        ({"turntable": 1.0, "frames": (5,)}, r"frames = \(5,\): expected \(first, end\) or"),
    ],
)
def test_what_makes_no_film_is_refused(given: dict[str, object], said: str) -> None:
    with pytest.raises(SettingError, match=said):
        Shots(**given)  # type: ignore[arg-type]


def test_ranges_are_read() -> None:
    assert frames_from_text("0:240") == (0, 240, 240)
    assert frames_from_text(" 100:140/240 ") == (100, 140, 240)


@pytest.mark.parametrize("text", ["", "3", "3:3", "4:3", "0:9/8", "-1:3", "0:9999999", "\uff11:3"])
def test_other_ranges_are_refused_in_one_line(text: str) -> None:
    with pytest.raises(SettingError, match=r"--frames-range .*expected A:B with A < B .*at most 5"):
        frames_from_text(text)


def test_numbers_of_numpy_are_rates_that_containers_take() -> None:
    assert type(Shots(turntable=90.0, fps=np.float32(10)).fps) is float
