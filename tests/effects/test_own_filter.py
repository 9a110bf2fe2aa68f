"""What rays found beyond R, averaged over pixels about: the shader against float64."""

from __future__ import annotations

import numpy as np
import pytest
from passes.estimator_cases import inputs_of, picture_frame, random_picture
from passes.pass_harness import STORED_AS, texture_from_image

from ssdo_gl.effects.own_rays import places_of
from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.texture import make_framebuffer, make_texture

TAN_Y = 0.5
TILE, SIDE = 8, 2
# As shaders/effects/own_filter.frag says.
REACH, STEP, FINE_STEP, FINE = 8, 4, 2, 0.9
# Of the normal along the view axis, as shaders/lib/far_probes.glsl says.
CODE = np.uint32(0x20000000 | 8192 | 8192 << 14).view(np.float32)
# Products of a dozen rounded factors, and normals of 16 bits.
ROUNDING = 2e-4
MANY = 100
# What is added to the light of all pixels, but those whose code says that they are in more light.
RARE = 0.25
IN_MORE_LIGHT = 3.0


def expected(picture, numbers, far, is_lit, stride, variance):
    """Return averages (n, 4) for the pixels that have `numbers`."""
    height, width = numbers.shape
    step = stride * (STEP if variance < FINE else FINE_STEP)
    reach = stride * REACH
    rows, columns = np.mgrid[:height, :width]
    p = picture.position(np.stack([columns, rows], -1))
    found = np.zeros((len(far), 4))
    for y, x in np.argwhere(numbers != 0):
        inv_reach = height / (FINE_STEP * stride * picture.z[y, x] * 2.0 * TAN_Y)
        total, weights = np.zeros(4), 0.0
        for v in range(y - reach, min(y + reach + 1, height), step):
            for u in range(x - reach, min(x + reach + 1, width), step):
                if min(u, v) < 0 or numbers[v, u] * numbers[y, x] <= 0:
                    continue
                if is_lit[abs(numbers[v, u]) - 1] != is_lit[abs(numbers[y, x]) - 1]:
                    continue
                d = (p[v, u] - p[y, x]) * inv_reach
                above = d @ picture.geometric[y, x]
                near = 1.0 / ((1.0 + above**2) * (1.0 + d @ d * (FINE_STEP / REACH) ** 2))
                alike = max(picture.shading[v, u] @ picture.shading[y, x], 0.0)
                weight = near**2 * alike**8
                total += weight * far[abs(numbers[v, u]) - 1]
                weights += weight
        found[abs(numbers[y, x]) - 1] = total / weights
    return found


# In small frames nothing is averaged up to .9, all from 1.8 on, and half-way between a half; in
# frames of 240 lines from .50625 on (180 lines over 240, squared), in large ones from .3.
@pytest.mark.parametrize(
    ("size", "variance", "share"),
    [
        ((24, 16), 0.5, 0.0),
        ((24, 16), 1.35, 0.5),
        ((24, 16), 3.0, 1.0),
        ((8, 240), 0.759375, 0.5),
        ((8, 360), 0.45, 0.5),
    ],
)
@pytest.mark.parametrize("stride", [1, 2])
def test_light_is_averaged_over_pixels_of_the_same_surface_and_kind(
    gl, shaders, size, variance, share, stride
):
    rng = np.random.default_rng(stride)
    picture = random_picture(stride, size, (TAN_Y * size[0] / size[1], TAN_Y), has_back=False)
    picture.z[:] = np.where(picture.z > 0.0, 2.0 + 1.6 / size[1] * picture.z, 0.0)
    # Normals that the probes' own agrees with.
    for normals in (picture.shading, picture.geometric):
        normals[:] = (normals - (0.0, 0.0, normals[..., 2].min())) * 0.2 + (0.0, 0.0, 1.0)
        normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    chosen = rng.permutation(np.flatnonzero(picture.z))
    places, pixels = places_of(chosen, MANY, size)
    far = np.zeros((*pixels.shape[:2], 4), np.float32)
    far.reshape(-1, 4)[: len(chosen)] = rng.random((len(chosen), 4))
    rare = np.zeros_like(far)
    is_lit = rng.random(len(chosen)) < 0.2
    rare.reshape(-1, 4)[: len(chosen), 3] = np.where(is_lit, IN_MORE_LIGHT, 1.0)
    tiles = size[0] // TILE, size[1] // TILE
    probes = np.zeros((tiles[1], tiles[0], 4), np.float32)
    probes[..., :3], probes[..., 3] = (0.0, 0.0, -2.2), CODE
    guide = np.zeros((2 * ((tiles[1] + 1) // 2 * 2) * SIDE, (tiles[0] + 1) // 2 * 2 * SIDE, 4))
    guide[..., 0], guide[..., 1] = np.sqrt(1.0 + variance), 1.0
    images = inputs_of(picture)
    textures = {
        **{
            f"t_{name}": texture_from_image(gl, images[name], STORED_AS.get(name, "f4"))
            for name in ("z_vs", "normals_vs")
        },
        "t_far_first_probes": make_texture(gl, tiles, 4, "f4", probes.tobytes()),
        "t_far_second_probes": make_texture(gl, tiles, 4, "f4", np.zeros_like(probes)),
        # Of the second probes, of which there are none, nothing is added.
        "t_spread_first": make_texture(gl, tiles, 4, "f4", np.full_like(probes, RARE)),
        "t_spread_second": make_texture(gl, tiles, 4, "f4", np.full_like(probes, 9.0)),
        "t_own_guide": make_texture(gl, guide.shape[1::-1], 4, "f4", guide),
        "t_own_pixels": make_texture(gl, pixels.shape[1::-1], 2, "f4", pixels),
        "t_own_places": make_texture(gl, size, 1, "i4", places),
        "t_own_far": make_texture(gl, far.shape[1::-1], 4, "f4", far),
        "t_own_rare": make_texture(gl, far.shape[1::-1], 4, "f4", rare),
    }
    averaged = make_texture(gl, far.shape[1::-1], 4, "f4")
    target = make_framebuffer(gl, [averaged])
    defines = {"PROBE_TILE": TILE, "PROBE_SIDE": SIDE}
    uniforms = {**picture_frame(size, TAN_Y).view.uniforms(), "u_stride": stride}
    program = shaders.fullscreen("effects/own_filter.frag", defines)
    draw_fullscreen(gl, program, target, uniforms, textures)
    found = np.frombuffer(averaged.read(), np.float32).reshape(-1, 4)[: len(chosen)]
    own = far.reshape(-1, 4)[: len(chosen)].astype(np.float64)
    wanted = expected(picture, places[..., 0], own, is_lit, stride, variance)
    added = np.where(is_lit[:, None], 0.0, [RARE, RARE, RARE, 0.0])
    np.testing.assert_allclose(found, own + share * (wanted - own) + added, rtol=0.0, atol=ROUNDING)
    # What is averaged would differ.
    assert share == 0.0 or np.abs(wanted - own).mean() > 0.1
