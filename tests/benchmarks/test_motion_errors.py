"""The bench of motion: its lag is that of images that follow by so much."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks import motion_errors
from ssdo_gl.gpu.context import create_context
from ssdo_gl.scene.load import load_scene


def waves(count: int, delay: float) -> np.ndarray:
    """Return frames of a pattern that changes evenly, behind by `delay` of them."""
    rng = np.random.default_rng(1)
    phase = rng.uniform(0.0, 2.0 * np.pi, (8, 16, 3))
    coarse = np.sin(phase + 0.05 * (np.arange(count)[:, None, None, None] - delay))
    return coarse.repeat(motion_errors.BLOCK, 1).repeat(motion_errors.BLOCK, 2)


@pytest.mark.parametrize("delay", [0.0, 1.0, 2.5])
def test_lag_is_told_in_spite_of_noise_and_bias(delay) -> None:
    found = waves(40, delay)
    found = found + np.random.default_rng(2).normal(0.2, 0.05, found.shape)
    assert motion_errors.lag(found, waves(40, 0.0)) == pytest.approx(delay, abs=0.15)


def test_a_pan_moves_the_target_by_so_many_pixels() -> None:
    scene = load_scene("corner")
    camera = motion_errors.pan(2.0)(scene, 3, 100)[1]
    step = np.subtract(camera.target, scene.camera.target)
    distance = np.linalg.norm(np.subtract(scene.camera.target, scene.camera.position))
    pixel = 2.0 * np.tan(np.radians(scene.camera.fov_y) / 2.0) * distance / 100.0
    assert np.linalg.norm(step) == pytest.approx(6.0 * pixel)


@pytest.mark.parametrize("name", motion_errors.CASES)
def test_every_case_moves(name) -> None:
    case = motion_errors.CASES[name]
    scene = load_scene(case.scene)
    first, second = (case.at(scene, i, 54) for i in (1, 2))
    is_same_camera = first[1] == second[1]
    assert is_same_camera == case.is_still
    assert first[0].lights != second[0].lights or first[1:] != second[1:]


@pytest.mark.parametrize("ghost", motion_errors.GHOSTS, ids=lambda g: f"{g.scene}-{g.method}")
def test_of_a_lamp_that_went_out_little_is_left(ghost) -> None:
    device = create_context("auto")
    try:
        left = motion_errors.ghosts(device, motion_errors.Extent((), (48, 27)), ghost)
    finally:
        device.release()
    assert len(left) == motion_errors.GHOST_FRAMES
    assert left[0] < 0.9 and abs(left[7]) < 0.1
    # What the lamp brought is gone from the picture, and its body with it.
    assert all(abs(later) <= max(abs(left[0]), 0.05) for later in left[4:])
