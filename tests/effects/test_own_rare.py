"""Light that few per-pixel rays find, summed by tile and averaged over tiles, against float64."""

from __future__ import annotations

import numpy as np
from effects.probe_codes import code_of
from passes.estimator_cases import picture_frame

from ssdo_gl.effects.own_rays import places_of
from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.texture import make_framebuffer, make_texture

# Tiles at the upper and right borders are cut off.
SIZE, TILE = (44, 28), 4
TILES = (11, 7)
TAN_Y = 0.5
# As shaders/effects/own_spread.frag and shaders/rays/guide.glsl say.
REACH, LEAST_AGREEMENT = 2, 0.8
# The first two are alike, by a cosine of .95, the others like none, by .5 at most.
NORMALS = np.array([[0.0, 0.0, 1.0], [0.3, 0.0, 0.95], [0.0, 0.9, 0.5], [-0.9, 0.0, 0.5]])
NORMALS /= np.linalg.norm(NORMALS, axis=1, keepdims=True)
# Of normals of 2 x 14 bits, times what planes lie apart.
ROUNDING = 1e-3


def filled(gl, shaders, shader, defines, uniforms, textures):
    """Return the image (2, rows, columns, n) that a shader fills, of first and second probes."""
    counts = (4, 2) if shader == "own_rare" else (4,)
    targets = [make_texture(gl, (TILES[0], 2 * TILES[1]), count, "f4") for count in counts]
    program = shaders.fullscreen(f"effects/{shader}.frag", defines)
    draw_fullscreen(gl, program, make_framebuffer(gl, targets), uniforms, textures)
    found = [np.frombuffer(t.read(), np.float32) for t in targets]
    images = [f.reshape(2, *TILES[::-1], -1) for f in found]
    return np.concatenate(images, axis=-1)


def test_what_is_rare_is_summed_by_the_surfaces_of_a_tile(gl, shaders) -> None:
    rng = np.random.default_rng(0)
    size = SIZE[0] - 1, SIZE[1] - 3
    chosen = rng.permutation(size[0] * size[1])[:700]
    places, pixels = places_of(chosen, 200, size)
    rare = np.zeros((*pixels.shape[:2], 4), np.float32)
    rare.reshape(-1, 4)[:700] = rng.random((700, 4))
    # No probe of the tile lies on its surface, the first one does, or the second.
    owners = rng.integers(0, 3, 700)
    rare.reshape(-1, 4)[:700, 3] = owners
    light = rng.random((*pixels.shape[:2], 2)).astype(np.float32)
    textures = {
        "t_own_places": make_texture(gl, size, 1, "i4", places),
        "t_own_rare": make_texture(gl, rare.shape[1::-1], 4, "f4", rare),
        "t_own_light": make_texture(gl, rare.shape[1::-1], 2, "f4", light),
    }
    found = filled(
        gl, shaders, "own_rare", {"PROBE_TILE": TILE}, {"u_tile_rows": TILES[1]}, textures
    )
    wanted = np.zeros((3, *TILES[::-1], 6))
    for number, (pixel, owner) in enumerate(zip(chosen, owners, strict=True)):
        tile = pixel // size[0] // TILE, pixel % size[0] // TILE
        own = rare.reshape(-1, 4)[number, :3], 1.0, light.reshape(-1, 2)[number]
        wanted[owner][tile] += np.hstack(own)
    np.testing.assert_allclose(found, wanted[1:], rtol=0.0, atol=1e-5)


def test_what_is_rare_is_averaged_over_probes_of_the_same_surface(gl, shaders) -> None:
    rng = np.random.default_rng(1)
    chosen = rng.integers(0, len(NORMALS), (2, *TILES[::-1]))
    chosen[rng.random(chosen.shape) < 0.3] = -1
    codes = np.array([code_of(normal) for normal in NORMALS])
    probes = np.zeros((*chosen.shape, 4), np.float32)
    # Within and beyond a tile of each other's planes, of which one pixel takes .0357 at depth 1.
    probes[..., :3] = rng.random((*chosen.shape, 3)) * (1.0, 1.0, 0.6) + (0.0, 0.0, -2.3)
    probes[..., 3] = np.where(rng.random(chosen.shape) < 0.5, -1.0, 1.0) * codes[chosen]
    probes[chosen < 0] = 0.0
    rare = rng.random(probes.shape).astype(np.float32)
    rare[..., 3] = rng.integers(0, 6, chosen.shape)
    rare[rare[..., 3] == 0.0] = 0.0
    # Means of at least a half, so that rounding hardly matters to what is divided by them.
    light = (0.5 + rng.random((*chosen.shape, 2))).astype(np.float32) * rare[..., 3:]
    images = {"t_far_probe_points": probes, "t_rare": rare, "t_light": light}
    textures = {
        name: make_texture(
            gl, (TILES[0], 2 * TILES[1]), i.shape[-1], "f4", np.concatenate(i).tobytes()
        )
        for name, i in images.items()
    }
    defines = {"PROBE_TILE": TILE, "PROBE_SIDE": 2}
    uniforms = picture_frame(SIZE, TAN_Y).view.uniforms()
    found = filled(gl, shaders, "own_spread", defines, uniforms, textures)

    wanted = np.zeros(probes.shape)
    for layer, y, x in np.argwhere(chosen >= 0):
        point, normal = probes[layer, y, x, :3].astype(float), NORMALS[chosen[layer, y, x]]
        extent = TILE * -point[2] * 2.0 * TAN_Y / SIZE[1]
        about = slice(max(y - REACH, 0), y + REACH + 1), slice(max(x - REACH, 0), x + REACH + 1)
        others = (slice(None), *about)
        height = (probes[others][..., :3] - point) @ normal / extent
        facing = np.where(chosen[others] >= 0, NORMALS[chosen[others]] @ normal, 0.0)
        weight = np.where(facing > LEAST_AGREEMENT, facing / (1.0 + height**2), 0.0)
        total = (weight[..., None] * rare[others]).sum(axis=(0, 1, 2))
        mean, variance = (weight[..., None] * light[others]).sum(axis=(0, 1, 2))
        wanted[layer, y, x, :3] = total[:3] / max(total[3], 1e-6)
        wanted[layer, y, x, 3] = variance * total[3] / mean**2 if mean > 0.0 else 0.0
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=ROUNDING)
    assert wanted[..., :3].std() > 0.01
