"""The bench of a walk: its errors are those that were put in, whatever the noise of the paths."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from benchmarks import walk_errors
from ssdo_gl.scene.load import load_scene

SHAPE = (2, 5, 40, 60, 3)


def test_errors_are_those_that_were_put_in() -> None:
    rng = np.random.default_rng(1)
    true = rng.uniform(0.5, 1.5, SHAPE)
    wrong = rng.normal(0.0, 0.05, SHAPE)
    noisy = [(true + rng.normal(0.0, 0.02, SHAPE)).astype(np.float32) for _ in range(2)]
    found = walk_errors.errors((true + wrong).astype(np.float32), *noisy)
    step = np.diff(wrong, axis=1)
    assert found.temporal == pytest.approx(np.abs(step).mean(), rel=0.02)
    assert found.rms == pytest.approx(np.sqrt((step**2).mean()), rel=0.02)
    assert found.error == pytest.approx(np.sqrt((wrong**2).mean()), rel=0.02)


def test_what_stays_wrong_is_no_temporal_error() -> None:
    rng = np.random.default_rng(2)
    true = rng.uniform(0.5, 1.5, SHAPE)
    found = walk_errors.errors(*(x.astype(np.float32) for x in (true + 0.3, true, true)))
    assert found.temporal < 1e-5
    assert found.error == pytest.approx(0.3, rel=1e-3)


def test_a_walk_looks_to_the_side_and_comes_ahead() -> None:
    scene = load_scene("cornell_meso")
    start, side, middle = (walk_errors.place(scene, n)[0] for n in (0, 75, 150))
    assert start == scene.camera
    ahead = np.subtract(side.target, side.position)
    before = np.subtract(start.target, start.position)
    cosine = ahead @ before / np.linalg.norm(ahead) / np.linalg.norm(before)
    assert np.degrees(np.arccos(cosine)) == pytest.approx(walk_errors.DEGREES)
    gone = np.subtract(middle.position, start.position)
    assert gone == pytest.approx(walk_errors.AHEAD * before)


def test_a_scene_that_moves_stands_before_a_camera_at_rest() -> None:
    scene = load_scene("carousel")
    assert walk_errors.place(scene, 30) == (scene.camera, 1.0)


def test_a_still_scene_repeats_its_table(device) -> None:
    extent = walk_errors.Extent((32, 18), 2, 1)
    scene = load_scene("corner")
    settings = dataclasses.replace(walk_errors.Settings("bounce"), size=extent.size, exposure=0.0)
    first = walk_errors.live(device, scene, settings, extent)
    assert first.shape == (1, walk_errors.STRETCH, 18, 32, 3)
    assert np.array_equal(first, walk_errors.live(device, scene, settings, extent))
