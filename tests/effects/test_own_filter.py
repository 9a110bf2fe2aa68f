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
STEPS, HEIGHT, TAPS, TOLERANCE = (1, 4), 2.0, 25, 3.0
# Of pixels with many rays, and of others.
RAYS = 16, 6
# Of the normal along the view axis, as shaders/lib/far_probes.glsl says.
CODE = np.uint32(0x20000000 | 8192 | 8192 << 14).view(np.float32)
# Products of a dozen rounded factors, and normals of 16 bits.
ROUNDING = 2e-4
MANY = 100
# Relative, of what aimed rays bring, averaged once.
AIMED_VARIANCE = 0.05
# Mean radiance of the environment.
SKY = 0.7
# What is added to the light of all pixels, but those whose code says that they are in more light.
RARE = 0.25
IN_MORE_LIGHT = 3.0


def same_light(a, b, variance):
    """Return how much pixels can be in the same light; the sky has a radiance of SKY."""
    light = np.array([np.mean(far[:3]) + SKY * far[3] for far in (a, b)])
    noise = TOLERANCE * variance * light @ light
    return 1.0 / (1.0 + (max((light[0] - light[1]) ** 2 - noise, 0.0) / noise) ** 2)


def expected(picture, numbers, far, is_lit, stride, variance, is_second):
    """Return averages (n, 4) for the pixels that have `numbers`; no variance: of aimed rays."""
    height, width = numbers.shape
    step = stride * STEPS[is_second]
    rows, columns = np.mgrid[:height, :width]
    p = picture.position(np.stack([columns, rows], -1))
    found = np.zeros((len(far), 4))
    for y, x in np.argwhere(numbers != 0):
        inv_pixel = height / (stride * picture.z[y, x] * 2.0 * TAN_Y)
        own = abs(numbers[y, x]) - 1
        total, weights = np.zeros(4), 0.0
        for v in range(y - 2 * step, min(y + 2 * step + 1, height), step):
            for u in range(x - 2 * step, min(x + 2 * step + 1, width), step):
                if min(u, v) < 0 or numbers[v, u] * numbers[y, x] <= 0:
                    continue
                other = abs(numbers[v, u]) - 1
                if is_lit[other] != is_lit[own]:
                    continue
                d = (p[v, u] - p[y, x]) * inv_pixel
                above = d @ picture.geometric[y, x] / HEIGHT
                near = 1.0 / ((1.0 + above**2) * (1.0 + d @ d / (2 * STEPS[is_second]) ** 2))
                alike = max(picture.shading[v, u] @ picture.shading[y, x], 0.0)
                weight = near**2 * alike**8
                if is_second:
                    of_one = variance and variance / (TAPS * RAYS[int(own >= MANY)])
                    of_one = of_one or AIMED_VARIANCE
                    weight *= same_light(far[other], far[own], of_one)
                total += weight * far[other]
                weights += weight
        found[own] = total / weights
    return found


# Nothing is averaged up to .2, all from .4 on, and half-way between a half.
@pytest.mark.parametrize(("variance", "share"), [(0.15, 0.0), (0.3, 0.5), (3.0, 1.0)])
@pytest.mark.parametrize("is_second", [False, True])
@pytest.mark.parametrize("stride", [1, 2])
def test_light_is_averaged_over_pixels_of_the_same_surface_and_kind(
    gl, shaders, variance, share, is_second, stride
):
    size = (24, 16)
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
    aimed = np.zeros_like(far)
    aimed.reshape(-1, 4)[: len(chosen), :3] = rng.random((len(chosen), 3))
    light = np.zeros_like(far)
    light.reshape(-1, 4)[: len(chosen), 2] = rng.random(len(chosen))
    rare = np.zeros_like(far)
    is_lit = rng.random(len(chosen)) < 0.2
    rare.reshape(-1, 4)[: len(chosen), 3] = np.where(is_lit, IN_MORE_LIGHT, 1.0)
    tiles = size[0] // TILE, size[1] // TILE * 2
    # Of the second probes, of which there are none, nothing is added.
    probes = np.zeros((2, tiles[1] // 2, tiles[0], 4), np.float32)
    probes[0, ..., :3], probes[0, ..., 3] = (0.0, 0.0, -2.2), CODE
    spread = np.full_like(probes, RARE)
    spread[0, ..., 3], spread[1] = variance, 9.0
    images = inputs_of(picture)
    textures = {
        **{
            f"t_{name}": texture_from_image(gl, images[name], STORED_AS.get(name, "f4"))
            for name in ("z_vs", "normals_vs")
        },
        "t_far_probe_points": make_texture(gl, tiles, 4, "f4", probes.tobytes()),
        "t_spread": make_texture(gl, tiles, 4, "f4", spread),
        "t_own_places": make_texture(gl, size, 1, "i4", places),
        "t_own_far": make_texture(gl, far.shape[1::-1], 4, "f4", far),
        "t_own_aimed": make_texture(gl, far.shape[1::-1], 4, "f4", aimed),
        "t_own_light": make_texture(gl, far.shape[1::-1], 4, "f4", light),
        "t_own_rare": make_texture(gl, far.shape[1::-1], 4, "f4", rare),
    }
    near = rng.random(far.shape).astype(np.float32)
    if is_second:
        textures["t_own_near"] = make_texture(gl, far.shape[1::-1], 4, "f4", near)
    else:
        textures["t_own_pixels"] = make_texture(gl, pixels.shape[1::-1], 2, "f4", pixels)
    made_size = size if is_second else far.shape[1::-1]
    averaged = [make_texture(gl, made_size, 4, "f4") for _ in range(2)]
    target = make_framebuffer(gl, averaged)
    defines = {
        "IS_SECOND": int(is_second),
        "BRIGHT_PIECES": 1,
        "OPENINGS": 1,
        "PROBE_TILE": TILE,
        "PROBE_SIDE": SIDE,
    }
    counts = {"u_many_rays": RAYS[0], "u_few_rays": RAYS[1], "u_many_count": MANY}
    view = picture_frame(size, TAN_Y).view
    uniforms = {**view.uniforms(), "u_stride": stride, "u_sky": SKY, **counts}
    program = shaders.fullscreen("effects/own_filter.frag", defines)
    draw_fullscreen(gl, program, target, uniforms, textures)
    images = [np.frombuffer(made.read(), np.float32).reshape(-1, 4) for made in averaged]
    assert not is_second or not any(image[places.ravel() == 0].any() for image in images)
    found, beside = (image[chosen] if is_second else image[: len(chosen)] for image in images)
    own, its = (light.reshape(-1, 4)[: len(chosen)].astype(np.float64) for light in (far, aimed))
    wanted = expected(picture, places[..., 0], own, is_lit, stride, variance, is_second)
    added = is_second * np.where(is_lit[:, None], 0.0, [RARE, RARE, RARE, 0.0])
    # So is what aimed rays bring, and then added.
    around = expected(picture, places[..., 0], its, is_lit, stride, None, is_second)
    blend = its + share * (around - its)
    added += is_second * blend
    # What comes through openings is added as it is.
    added[:, 3] += is_second * light.reshape(-1, 4)[: len(chosen), 2]
    if is_second:
        # Negative depths tell which pixels have many rays.
        signs = np.where(np.arange(len(chosen)) < MANY, -1.0, 1.0)[:, None] ** [0, 0, 0, 1]
        np.testing.assert_array_equal(beside, near.reshape(-1, 4)[: len(chosen)] * signs)
    else:
        np.testing.assert_allclose(beside, blend, rtol=0.0, atol=ROUNDING)
    np.testing.assert_allclose(found, own + share * (wanted - own) + added, rtol=0.0, atol=ROUNDING)
    # What is averaged would differ.
    assert share == 0.0 or np.abs(wanted - own).mean() > 100.0 * ROUNDING
