"""The bench of a camera that stops: it finds the steps that were put in."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks import stop_steps
from ssdo_gl.scene.load import load_scene

SHAPE = (9, 16, 3)


def test_the_largest_step_is_the_one_that_was_put_in() -> None:
    levels = (1.0, 1.01, 1.06, 1.0)
    images = [np.full(SHAPE, level, np.float32) for level in levels]
    images[1][0, 0] += 0.3
    of_mean, rms = stop_steps.largest_steps(images)
    assert of_mean == pytest.approx(0.06, rel=1e-3)
    assert rms == pytest.approx(0.06, rel=1e-3)
    flat = [np.ones(SHAPE, np.float32)] * 2
    assert stop_steps.largest_steps(flat) == (0.0, 0.0)


def test_a_step_aside_is_across_the_view() -> None:
    camera = load_scene("stairs").camera
    moved = stop_steps.aside(camera, 3)
    ahead = np.subtract(camera.target, camera.position)
    move = np.subtract(moved.position, camera.position)
    assert abs(move @ ahead) < 1e-9
    assert np.linalg.norm(move) == pytest.approx(3 * stop_steps.STEP * np.linalg.norm(ahead))
    assert np.subtract(moved.target, camera.target) == pytest.approx(move)


def test_a_stop_begins_with_the_last_frame_of_the_walk_and_ends_at_rest(device) -> None:
    walk, stop = stop_steps.frames(device, "corner", (32, 18))
    assert len(walk) == stop_steps.WALK
    assert np.array_equal(walk[-1], stop[0])
    # Rays of pixels' own are traced in sixteen frames.
    assert len(stop) == 1 + 16


def test_a_table_has_a_row_for_each_scene(capsys: pytest.CaptureFixture[str]) -> None:
    assert stop_steps.main(["corner", "--size", "32x18"]) == 0
    assert capsys.readouterr().out.splitlines()[-1].startswith("| corner | ")
