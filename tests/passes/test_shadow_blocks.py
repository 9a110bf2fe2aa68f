"""Squares of texels of shadow maps: planes between which all that they hold lies."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.gpu.context import draws_on_cpu
from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.passes.quads import quads_of
from ssdo_gl.passes.shadow_blocks import BLOCK_LEVELS, BLOCK_TEXELS, ShadowBlocks
from ssdo_gl.scene.shadow_frames import ShadowFrame

SIZE = 128
FAR = 40.0
# Of nearness, by the rounding of a sum of a few terms in float32.
ROUNDING = 1e-5


def depths_of(kind):
    """A map of one face: a plane, steps between planes with gaps, or noise."""
    y, x = np.mgrid[:SIZE, :SIZE].astype(np.float64)
    rng = np.random.default_rng(3)
    if kind == "plane":
        return 1.0 / (0.2 + 0.001 * x + 0.002 * y)
    if kind == "steps":
        steps = 2.0 + (x // 37) + 0.5 * (y // 21)
        return np.where((x // 16 + y // 16) % 5 == 0, 3.0e38, steps)
    return rng.uniform(1.0, 20.0, (SIZE, SIZE))


@pytest.mark.parametrize("is_parallel", [False, True])
@pytest.mark.parametrize("kind", ["plane", "steps", "noise"])
def test_all_texels_lie_between_the_planes(gl, shaders, kind, is_parallel):
    if not draws_on_cpu(gl):
        pytest.skip("only processors read quads")
    depths = depths_of(kind)
    atlas = make_texture(gl, (SIZE, SIZE), 1, "f4", depths[..., None])
    quads_of(gl, shaders, atlas, gl)
    frame = ShadowFrame(
        np.zeros(3), np.eye(3), is_parallel, (1.0, 1.0), 0.5 * FAR, 1, (0, 0), 1, np.zeros((1, 3))
    )
    blocks = ShadowBlocks(gl, shaders, quads_of(gl, shaders, atlas, gl), [frame], SIZE)
    columns, rows = blocks.grid
    width, height = blocks.texture.size
    stored = np.frombuffer(blocks.texture.read(), np.float32).reshape(height, width, 4)
    nearness = -np.minimum(depths, FAR) if is_parallel else 1.0 / depths
    corner = 0
    for level in range(BLOCK_LEVELS):
        size = BLOCK_TEXELS << level
        if size > SIZE:
            break
        x0, y0 = (0, 0) if level == 0 else (columns, corner)
        corner += rows >> level if level else 0
        centre = 0.5 * (size - 1)
        y, x = np.mgrid[:size, :size] - centre
        for j, i in np.ndindex(SIZE // size, SIZE // size):
            a, b, high, low = stored[y0 + j, x0 + i].astype(np.float64)
            texels = nearness[j * size : (j + 1) * size, i * size : (i + 1) * size]
            rest = texels - a * x - b * y
            slack = ROUNDING * np.abs(nearness).max()
            assert low - slack <= rest.min()
            assert rest.max() <= high + slack
            if kind == "plane" and not is_parallel:
                assert high - low < slack
