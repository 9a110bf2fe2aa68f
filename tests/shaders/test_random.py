"""Sample points: evenly spread, uniform one by one, independent; how many a block traces."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from passes.pass_harness import texture_from_image
from shaders.harness import evaluate

from ssdo_gl.passes.rays.accumulate import shared_bits_mask


def points(gl, shaders, call: str, index, seed, *, stream: int = 9, shared: int = 0) -> NDArray:
    out = evaluate(
        gl,
        shaders,
        ["lib/random.glsl"],
        call,
        {"index": np.asarray(index, np.uint32), "seed": np.asarray(seed, np.uint32)},
        2,
        uniforms={"u_stream": stream, "u_shared_bits": shared},
    )
    return out.astype(np.float64)


CALLS = ["random_2d(index, seed, 3u, false)", "random_2d(index, seed, 3u, true)"]


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("seed", [0, 1, 77])
@pytest.mark.parametrize("start", [0, 64])
def test_every_elementary_box_holds_one_point(gl, shaders, call, seed, start) -> None:
    u = points(gl, shaders, call, start + np.arange(64), np.full(64, seed), shared=3)
    assert u.min() >= 0.0
    assert u.max() < 1.0
    for bits in range(7):
        columns, rows = 1 << bits, 64 >> bits
        boxes = np.floor(u[:, 0] * columns) * rows + np.floor(u[:, 1] * rows)
        assert len(np.unique(boxes)) == 64


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("index", [0, 5, 1000])
def test_one_point_is_uniform_over_seeds(gl, shaders, call, index) -> None:
    if "true" in call:
        # Its leading bits are drawn once for all pixels: uniform over streams.
        u = np.concatenate(
            [
                points(gl, shaders, call, [index], [1], stream=stream, shared=3)
                for stream in range(600)
            ]
        )
    else:
        u = points(gl, shaders, call, np.full(4096, index), np.arange(4096))
    for values in u.T:
        # Kolmogorov-Smirnov at 1e-4: 2.23 / sqrt(n).
        gap = np.abs(np.sort(values) - (np.arange(len(values)) + 0.5) / len(values)).max()
        assert gap < 2.23 / np.sqrt(len(values))


def test_neighbours_share_leading_bits_and_nothing_else(gl, shaders) -> None:
    call = "random_2d(index, seed, 0u, true)"
    u = np.stack(
        [
            points(
                gl, shaders, call, np.arange(256), np.full(256, seed), shared=shared_bits_mask(256)
            )
            for seed in (1, 2)
        ]
    )
    assert shared_bits_mask(256) == 15
    cells = np.floor(u * 16.0)
    np.testing.assert_array_equal(cells[0], cells[1])
    assert len(np.unique(cells[0], axis=0)) == 256
    inside = u * 16.0 - cells
    for axis in range(2):
        # Correlation of 256 independent pairs: standard deviation 1 / 16.
        assert abs(np.corrcoef(inside[0, :, axis], inside[1, :, axis])[0, 1]) < 4.0 / 16.0


@pytest.mark.parametrize(("count", "mask"), [(0, 0), (1, 0), (3, 0), (4, 1), (16, 3), (255, 7)])
def test_shared_cells_are_no_more_than_samples(count: int, mask: int) -> None:
    assert shared_bits_mask(count) == mask


def test_dimensions_are_independent(gl, shaders) -> None:
    index, seed = np.arange(1024), np.full(1024, 3)
    first = points(gl, shaders, "random_2d(index, seed, 1u, false)", index, seed)
    second = points(gl, shaders, "random_2d(index, seed, 2u, false)", index, seed)
    both = np.concatenate([first, second], axis=1)
    # Joint cells of 4 x 4 over any two dimensions: chi-square with 15 degrees stays
    # below 45 but once in 13 000; correlated sequences give hundreds.
    for i in range(4):
        for j in range(i):
            cells = np.floor(both[:, i] * 4) * 4 + np.floor(both[:, j] * 4)
            counts = np.bincount(cells.astype(int), minlength=16)
            assert np.sum((counts - 64.0) ** 2 / 64.0) < 45.0


@pytest.mark.parametrize("count", [1, 6, 8, 48])
def test_points_in_step_are_a_pixels_own_in_one_order(gl, shaders, count: int) -> None:
    pixels = 16
    index, seed = np.arange(pixels * count), np.full(pixels * count, 7)
    own = points(gl, shaders, "random_2d(index, seed, 3u, false)", index, seed)
    call = f"random_2d_in_step(index - index % {count}u, index % {count}u, {count}u, seed, 3u)"
    stepped = points(gl, shaders, call, index, seed)
    own, stepped = (u.reshape(pixels, count, 2) for u in (own, stepped))
    for a, b in zip(own, stepped, strict=True):
        assert {(x, y) for y, x in a.tolist()} == {(x, y) for x, y in b.tolist()}
    # The largest power of two in `count` is how many strips pixels go through together.
    strips = count & -count
    strip = np.floor(stepped[..., 1] * strips)
    np.testing.assert_array_equal(strip, np.broadcast_to(strip[0], strip.shape))
    assert len(np.unique(strip[0, :strips])) == strips


# The last block of each row and column is cut off by the frame's edge.
SIZE = (10, 5)
# As shaders/lib/ray_blocks.glsl says.
BLOCK = (4, 2)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_pixel_traces_as_many_as_any_of_its_block(gl, shaders, seed) -> None:
    rng = np.random.default_rng(seed)
    columns, rows = np.meshgrid(*map(np.arange, SIZE))
    numbers = rng.integers(-20, 21, (SIZE[1], SIZE[0])).astype(np.int32)
    expected = np.zeros_like(numbers)
    for y in range(0, SIZE[1], BLOCK[1]):
        for x in range(0, SIZE[0], BLOCK[0]):
            block = (slice(y, y + BLOCK[1]), slice(x, x + BLOCK[0]))
            expected[block] = abs(numbers[block]).max()
    found = evaluate(
        gl,
        shaders,
        ["lib/ray_blocks.glsl"],
        "float(number_of_rays(texel))",
        {"texel": np.stack([columns.ravel(), rows.ravel()], 1)},
        textures={"t_numbers": texture_from_image(gl, numbers[::-1], "i4")},
    )
    assert (expected > abs(numbers)).any()
    np.testing.assert_array_equal(found.ravel(), expected.ravel())
