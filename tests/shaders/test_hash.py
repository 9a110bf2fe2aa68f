"""The interleaved sample pattern: complete, unique, even, exactly reproducible."""

from __future__ import annotations

import numpy as np
import pytest
from oracle import screen_space
from shaders.harness import evaluate

INCLUDES = ["lib/hash.glsl"]
OFFSET = (123456789, 4000000000, 77)


def sets_of(gl, shaders, pixels):
    return evaluate(
        gl, shaders, INCLUDES, "set_of_pixel(pixel)", {"pixel": pixels}, output_dtype="u4"
    )[:, 0]


def points_of(gl, shaders, index, offset=OFFSET):
    return evaluate(
        gl,
        shaders,
        INCLUDES,
        "kronecker_point(index, u_offset)",
        {"index": np.asarray(index, np.uint32)},
        3,
        functions="uniform uvec3 u_offset;",
        uniforms={"u_offset": offset},
    )


def block_pixels(corner=(0, 0)):
    y, x = np.divmod(np.arange(16), 4)
    return np.stack([x + corner[0], y + corner[1]], 1)


def test_every_4x4_block_holds_every_set_once(gl, shaders):
    """Any 4 x 4 window, not only aligned ones, or a 4-tap box would not see them all."""
    for corner in ((0, 0), (1, 2), (1023, 517)):
        assert sorted(sets_of(gl, shaders, block_pixels(corner))) == list(range(16))


def test_every_2x2_quarter_spreads_its_sets(gl, shaders):
    """Bayer: the sets of a quarter lie 4 apart or more, so their points interleave."""
    sets = sets_of(gl, shaders, block_pixels()).reshape(4, 4).astype(int)
    for y in (0, 2):
        for x in (0, 2):
            assert np.diff(np.sort(sets[y : y + 2, x : x + 2].ravel())).min() >= 4


def test_sets_match_the_twin(gl, shaders):
    sets = sets_of(gl, shaders, block_pixels()).reshape(4, 4)
    np.testing.assert_array_equal(sets, screen_space.BAYER)


def test_points_match_the_twin_exactly(gl, shaders):
    """Integers: no rounding, on any machine."""
    index = np.concatenate([np.arange(1024), [65535, 2**31, 2**32 - 1]])
    expected = screen_space.kronecker_points(index.astype(np.int64), OFFSET)
    np.testing.assert_array_equal(points_of(gl, shaders, index), expected.astype(np.float32))


def test_points_stay_below_one(gl, shaders):
    """An offset of 2^32 - 1 at index 0 is the largest fraction there is."""
    points = points_of(gl, shaders, [0], (2**32 - 1,) * 3)
    assert points.max() < 1.0


@pytest.mark.parametrize("directions", [1, 3, 8, 64])
def test_no_point_of_a_block_is_used_twice(gl, shaders, directions):
    """Set s takes points s N .. s N + N - 1, as screen_space/receiver.glsl counts them."""
    points = points_of(gl, shaders, np.arange(16 * directions))
    assert len(np.unique(points, axis=0)) == 16 * directions
    for coordinate in range(3):
        assert len(np.unique(points[:, coordinate])) == 16 * directions


def wall_error(points):
    """Return the RMS error of a block's mean occlusion by random walls.

    A direction is found blocked by a wall at k R in azimuth phi if the last of 8 marched
    points lies beyond it, which takes all three coordinates of a point.
    """
    rng = np.random.default_rng(5)
    k, phi = 0.02 + 0.7 * rng.random((400, 1)), 2.0 * np.pi * rng.random((400, 1))

    def occlusion(u):
        x = np.sqrt(u[:, 0]) * np.cos(2.0 * np.pi * u[:, 1] - phi)
        return np.mean(x * ((7.0 + u[:, 2]) / 8.0) >= k, axis=1)

    dense = screen_space.kronecker_points(np.arange(1 << 12), (0, 0, 0))
    return float(np.sqrt(np.mean((occlusion(points) - occlusion(dense)) ** 2)))


# Share of white noise's error that a block may have. Measured .57, .37 and .31 for 1, 4
# and 16 directions, to about a tenth; with the azimuths or the radii shuffled .64 to .68,
# .55 and .46.
ERROR_SHARE = {1: 0.63, 4: 0.45, 16: 0.38}


@pytest.mark.parametrize("directions", [1, 4, 16])
def test_block_samples_walls_evenly(gl, shaders, directions):
    count = 16 * directions
    rng = np.random.default_rng(1)
    white = np.mean([wall_error(rng.random((count, 3))) for _ in range(8)])
    offsets = rng.integers(0, 2**32, (8, 3))
    even = np.mean(
        [wall_error(points_of(gl, shaders, np.arange(count), tuple(map(int, o)))) for o in offsets]
    )
    assert even < ERROR_SHARE[directions] * white


@pytest.mark.parametrize("rays", [1, 6])
def test_every_block_of_pixels_takes_points_that_follow_each_other(gl, shaders, rays) -> None:
    side = 32
    y, x = np.mgrid[:side, :side].reshape(2, -1)
    found = evaluate(
        gl,
        shaders,
        ["lib/z_curve.glsl"],
        "first_point(texel, rays)",
        {"texel": np.stack([x, y], -1), "rays": np.full(side * side, rays)},
        output_dtype="u4",
    ).reshape(side, side)
    assert np.array_equal(np.sort(found.reshape(-1)), rays * np.arange(side * side))
    for block in (2, 4, 8, 16):
        blocks = found.reshape(side // block, block, side // block, block).swapaxes(1, 2)
        blocks = blocks.reshape(-1, block * block).astype(np.int64)
        assert np.all(np.ptp(blocks, axis=1) == rays * (block * block - 1))
