"""Rays of pixels' own: in which order pixels take points of their sequence."""

from __future__ import annotations

import numpy as np
import pytest
from shaders.harness import evaluate

INCLUDES = [
    "rays/surface_cache.glsl",
    "lib/environment.glsl",
    "lib/random.glsl",
    "lib/gbuffer.glsl",
    "lib/pixel_centre.glsl",
    "rays/arriving.glsl",
]
DEFINES = {
    "BVH_LEVELS": 1,
    "BVH_STACK_IN_REGISTERS": 1,
    "BVH_FUSES": 0,
    "RAY_SMOOTH_NORMALS": 0,
    "RAY_VERTEX_COLORS": 0,
    "RAY_TEXTURES": 0,
    "RAY_CUTOUTS": 0,
    "RAY_SINGLE_SIDED": 0,
    "RAY_SECOND_UVS": 0,
    "RAY_NORMAL_MAPS": 0,
    "RAY_TANGENTS": 0,
    "GLOSSY": 0,
    "ENVIRONMENT_KIND": 0,
}


@pytest.mark.parametrize("rays", [1, 6])
def test_every_block_of_pixels_takes_points_that_follow_each_other(gl, shaders, rays) -> None:
    side = 32
    y, x = np.mgrid[:side, :side].reshape(2, -1)
    found = evaluate(
        gl,
        shaders,
        INCLUDES,
        "first_point(texel, rays)",
        {"texel": np.stack([x, y], -1), "rays": np.full(side * side, rays)},
        output_dtype="u4",
        defines=DEFINES,
    ).reshape(side, side)
    assert np.array_equal(np.sort(found.reshape(-1)), rays * np.arange(side * side))
    for block in (2, 4, 8, 16):
        blocks = found.reshape(side // block, block, side // block, block).swapaxes(1, 2)
        blocks = blocks.reshape(-1, block * block).astype(np.int64)
        assert np.all(np.ptp(blocks, axis=1) == rays * (block * block - 1))
