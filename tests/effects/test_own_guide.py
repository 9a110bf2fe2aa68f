"""What per-pixel rays follow: the guide's shader against float64."""

from __future__ import annotations

import numpy as np
import pytest
from effects.probe_codes import code_of

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.texture import make_framebuffer, make_texture

SIDE = 4
SKY = 0.7
# As shaders/effects/own_guide.frag says.
OWN_WEIGHT = 4.0
# As shaders/lib/probe_cells.glsl says.
SAME_DIRECTIONS = 0.9
# Two of them are alike.
NORMALS = np.array([[0.0, 0.0, 1.0], [0.3, 0.0, 0.954], [0.8, 0.0, 0.6]])
ROUNDING = 2e-6


def probes_of(rng, tiles):
    """Return which normal first and second probes have (2, rows, columns), -1: there is none."""
    chosen = rng.integers(0, len(NORMALS), (2, tiles[1], tiles[0]))
    chosen[1][rng.random(chosen[1].shape) < 0.6] = -1
    chosen[:, rng.random(chosen[1].shape) < 0.2] = -1
    return chosen


def expected(chosen, far):
    """Return density, mean radiance, open share and its mean (rows, columns, 4), of all texels."""
    rows, columns = chosen.shape[1:]
    light = far[..., :3].mean(-1) + (1.0 - far[..., 3]) * SKY
    open_sky = 1.0 - far[..., 3]
    guide = np.zeros((*light.shape, 4))

    def corner(layer, y, x):
        return np.array([x, y + layer * rows]) * SIDE

    def alike(y, x, normal):
        """Return the corner of the probe of a tile that has the same directions, or None."""
        for layer in (0, 1):
            other = chosen[layer, y, x]
            if other >= 0 and NORMALS[other] @ normal > SAME_DIRECTIONS:
                return corner(layer, y, x)
        return None

    for layer, y, x in np.argwhere(chosen >= 0):
        normal, at = NORMALS[chosen[layer, y, x]], corner(layer, y, x)
        about = [
            alike(v, u, normal)
            for v in range(max(y - 2, 0), min(y + 3, rows))
            for u in range(max(x - 2, 0), min(x + 3, columns))
        ]
        for v in range(SIDE):
            for u in range(SIDE):
                own = (at[1] + v, at[0] + u)
                rows_near = slice(at[1] + max(v - 1, 0), at[1] + min(v + 2, SIDE))
                near = rows_near, slice(at[0] + max(u - 1, 0), at[0] + min(u + 2, SIDE))
                beside = [(c[1] + v, c[0] + u) for c in about if c is not None]

                def mean(values, own=own, near=near, beside=beside):
                    found = [*values[near].ravel(), *(values[c] for c in beside)]
                    return (OWN_WEIGHT * values[own] + sum(found)) / (OWN_WEIGHT + len(found))

                shares = open_sky[own], mean(open_sky)
                guide[own] = np.sqrt(mean(light**2)), mean(light), *shares
    return guide


@pytest.mark.parametrize("tiles", [(5, 4), (4, 3)])
def test_the_guide_is_the_root_mean_square_of_a_cell_and_those_beside(gl, shaders, tiles):
    rng = np.random.default_rng(tiles[0])
    chosen = probes_of(rng, tiles)
    codes = np.zeros((*chosen.shape, 4), np.float32)
    for at in np.argwhere(chosen >= 0):
        codes[(*at, 3)] = code_of(NORMALS[chosen[tuple(at)]])
    # Those of first probes of tiles that have a second one are negative.
    codes[0, ..., 3] *= np.where(chosen[1] >= 0, -1.0, 1.0)
    points = np.concatenate(codes)
    size = tiles[0] * SIDE, 2 * tiles[1] * SIDE
    far = rng.random((size[1], size[0], 4)).astype(np.float32) ** 3
    textures = {
        "t_far_probe_points": make_texture(gl, points.shape[1::-1], 4, "f4", points.tobytes()),
        "t_far_radiance": make_texture(gl, size, 4, "f4", far),
    }
    guide = make_texture(gl, size, 4, "f4")
    target = make_framebuffer(gl, [guide])
    program = shaders.fullscreen("effects/own_guide.frag", {"PROBE_SIDE": SIDE})
    draw_fullscreen(gl, program, target, {"u_sky": SKY}, textures)
    found = np.frombuffer(guide.read(), np.float32).reshape(size[1], size[0], 4)
    wanted = expected(chosen, far.astype(np.float64))
    assert (wanted[..., 0] > 0.0).any() and (wanted[..., 0] == 0.0).any()
    np.testing.assert_allclose(found, wanted, rtol=ROUNDING, atol=ROUNDING)
