"""How many rays the pixels of a block trace."""

from __future__ import annotations

import numpy as np
import pytest
from passes.pass_harness import texture_from_image
from shaders.harness import evaluate

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
