"""Windows are found by the rays that leave a room through them, and nothing else is."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.math3d import FloatArray
from ssdo_gl.raytracing.openings import openings_of
from ssdo_gl.raytracing.packed import oct_words, unit_vectors
from ssdo_gl.raytracing.surfel_points import cosine_ways

SURFELS, RAYS = 6000, 16
TURNED = np.array([[0.6, 0.0, 0.8], [0.48, 0.8, -0.36], [-0.64, 0.6, 0.48]])
# In the wall at x = 1 of the cube from -1 to 1: low and high corners along y and z.
WINDOW, SLIT = ((0.1, -0.3), (0.5, 0.2)), ((-0.6, 0.5), (-0.5, 0.8))


def surfels() -> tuple[FloatArray, np.ndarray, FloatArray]:
    """Return places, words of normals and ways (S, N) of rays of surfels within a cube."""
    rng = np.random.default_rng(5)
    axis, side = rng.integers(0, 3, SURFELS), rng.choice((-1.0, 1.0), SURFELS)
    starts = rng.uniform(-1.0, 1.0, (SURFELS, 3))
    starts[np.arange(SURFELS), axis] = side
    normals = np.zeros((SURFELS, 3))
    normals[np.arange(SURFELS), axis] = -side
    words = np.repeat(oct_words(normals)[:, None], RAYS, axis=1)
    return np.repeat(starts[:, None], RAYS, axis=1), words, cosine_ways(words)


def leaving(starts: FloatArray, ways: FloatArray, *windows: object) -> np.ndarray:
    """Return which rays leave the cube by one of the windows."""
    t = (1.0 - starts[..., 0]) / np.where(ways[..., 0] > 1e-6, ways[..., 0], np.inf)
    at = (starts + t[..., None] * ways)[..., 1:]
    is_through = np.zeros(t.shape, dtype=bool)
    for low, high in np.array(windows, dtype=float):
        is_through |= (t > 1e-6) & ((at > low) & (at < high)).all(axis=-1)
    return is_through


def bounds(opening: FloatArray) -> tuple[FloatArray, FloatArray]:
    corners = opening[0] + np.array([[0, 0], [1, 0], [0, 1], [1, 1]]) @ opening[1:]
    return corners.min(axis=0), corners.max(axis=0)


@pytest.mark.parametrize("windows", [(WINDOW,), (WINDOW, SLIT)], ids=["one", "two"])
@pytest.mark.parametrize("turn", [np.eye(3), TURNED], ids=["upright", "turned"])
def test_windows_are_found_wherever_walls_stand(windows: tuple, turn: FloatArray) -> None:
    starts, words, ways = surfels()
    is_open = leaving(starts, ways, *windows)
    found = openings_of(starts @ turn, ways @ turn, oct_words(unit_vectors(words) @ turn), is_open)
    assert len(found) == len(windows)
    found = found[np.argsort([-np.linalg.norm(np.cross(o[1], o[2])) for o in found])]
    for opening, window in zip(found, windows, strict=True):
        low, high = bounds(opening @ turn.T)
        np.testing.assert_allclose(np.stack([low, high])[:, 1:], window, atol=0.05)
        np.testing.assert_allclose([low[0], high[0]], 1.0, atol=0.1)


def test_a_missing_wall_is_none() -> None:
    starts, words, ways = surfels()
    assert not len(openings_of(starts, ways, words, leaving(starts, ways, ((-1, -1), (1, 1)))))


def test_nor_is_what_few_rays_or_single_ones_pass() -> None:
    starts, words, ways = surfels()
    is_open = leaving(starts, ways, WINDOW)
    few = is_open & (np.cumsum(is_open).reshape(is_open.shape) <= 20)
    assert not len(openings_of(starts, ways, words, few))
    scattered = np.random.default_rng(1).random(is_open.shape) < 0.01
    assert not len(openings_of(starts, ways, words, scattered))
    assert not len(openings_of(starts, ways, words, np.zeros_like(is_open)))


def test_what_a_wall_hides_from_the_room_is_none() -> None:
    starts, words, ways = surfels()
    is_open = leaving(starts, ways, WINDOW)
    # Of a crack below the floor, which the room's own rays do not pass.
    rng = np.random.default_rng(2)
    below = np.concatenate([rng.uniform(-1.0, 1.0, (400, 2)), np.full((400, 1), -1.02)], axis=1)
    below = np.repeat(below[:, None, [0, 2, 1]], RAYS, axis=1)
    under = np.zeros((400, RAYS), dtype=bool)
    under[:, :2] = True
    flat = np.repeat(oct_words(np.tile([0.0, -1.0, 0.0], (400, 1)))[:, None], RAYS, axis=1)
    found = openings_of(
        np.concatenate([starts, below]),
        np.concatenate([ways, cosine_ways(flat)]),
        np.concatenate([words, flat]),
        np.concatenate([is_open, under]),
    )
    assert len(found) == 1
    low, high = bounds(found[0])
    np.testing.assert_allclose(np.stack([low, high])[:, 1:], WINDOW, atol=0.05)
