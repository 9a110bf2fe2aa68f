"""Pixels around which little of their surface shows, against float64."""

from __future__ import annotations

import numpy as np
import pytest
from oracle import analytic_pictures
from oracle.analytic_pictures import Picture
from passes.estimator_cases import NEAR, float32, inputs_of, picture_frame, stored
from passes.pass_harness import STORED_AS, texture_from_image
from shaders.harness import evaluate

SIZE = (24, 16)
TAN_Y = 0.5
TAN_HALF = (TAN_Y * SIZE[0] / SIZE[1], TAN_Y)
# As shaders/lib/outline_pixels.glsl and shaders/lib/gbuffer.glsl say.
FEWEST_ALIKE = 3
LEAST_TURN = 0.43
# What hangs on less is rounding's to decide.
TIE = 1e-4


def two_planes(seed: int) -> Picture:
    """Return texels of either of two tilted planes, and some of nothing, by chance."""
    rng = np.random.default_rng(seed)
    rays = analytic_pictures.view_rays(SIZE, TAN_HALF)
    shape = rays.shape[:2]
    normals = np.array([[0.3, 0.2, 1.0], [0.1, -0.4, 1.0]])
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    chosen = (rng.random(shape) < 0.45).astype(int)
    geometric = stored(normals[chosen])
    along = (rays / -rays[..., 2:] * geometric).sum(-1)
    # Some texels stand up to two of their heights off their plane.
    height = 2.0 * TAN_Y * 2.0 / SIZE[1]
    off = np.where(rng.random(shape) < 0.6, rng.uniform(-2.0, 2.0, shape) * height, 0.0)
    z = float32((off - 2.0) / along) * (rng.random(shape) > 0.05)
    shading = geometric + 0.1 * rng.normal(size=rays.shape)
    shading /= np.linalg.norm(shading, axis=-1, keepdims=True)
    return Picture(z, stored(shading), geometric, TAN_HALF, NEAR, None)


def expected(picture: Picture, stride: int) -> tuple[np.ndarray, np.ndarray]:
    """Return outlines (height, width), row 0 at the bottom, and where they are sure."""
    width, height = SIZE
    rows, columns = np.mgrid[:height, :width]
    p, n, has = (
        picture.position(np.stack([columns, rows], -1)),
        *(picture.geometric, picture.z > 0.0),
    )
    footprint = picture.z * 2.0 * TAN_Y / height * stride
    codes = analytic_pictures.oct_encode(picture.shading) / 65535.0
    alike, sure = np.zeros(has.shape, int), np.ones(has.shape, bool)
    for y in (-stride, 0, stride):
        for x in (-stride, 0, stride):
            if x == y == 0:
                continue
            at = np.clip(rows + y, 0, height - 1), np.clip(columns + x, 0, width - 1)
            off = np.abs(((p[at] - p) * n).sum(-1)) / np.where(has, footprint, 1.0)
            turn = 2.0 * np.linalg.norm(codes[at] - codes, axis=-1)
            alike += has[at] & (off < 1.0) & (turn < LEAST_TURN)
            sure &= ~has[at] | (np.minimum(abs(off - 1.0), abs(turn - LEAST_TURN)) > TIE)
    return alike < FEWEST_ALIKE, sure & has


@pytest.mark.parametrize("stride", [1, 2])
@pytest.mark.parametrize("seed", range(3))
def test_outlines_are_where_little_of_the_surface_shows_around(gl, shaders, seed, stride):
    picture = two_planes(seed)
    images = inputs_of(picture)
    textures = {
        f"t_{name}": texture_from_image(gl, images[name], STORED_AS.get(name, "f4"))
        for name in ("z_vs", "normals_vs")
    }
    rows, columns = np.mgrid[: SIZE[1], : SIZE[0]]
    found = evaluate(
        gl,
        shaders,
        ["lib/outline_pixels.glsl"],
        f"is_outline(texel, {stride}) ? 1.0 : 0.0",
        {"texel": np.stack([columns.ravel(), rows.ravel()], 1)},
        uniforms=picture_frame(SIZE, TAN_Y).view.uniforms(),
        textures=textures,
    )
    wanted, sure = expected(picture, stride)
    assert sure.mean() > 0.8
    assert 0.1 < wanted[sure].mean() < 0.9
    np.testing.assert_array_equal(found.reshape(wanted.shape)[sure] > 0.5, wanted[sure])
