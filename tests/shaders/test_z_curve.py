"""In which order pixels take points of the sequence of their rays."""

from __future__ import annotations

import numpy as np
import pytest
from shaders.harness import evaluate


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
