"""Which pixels have many rays of their own: their shader against float64."""

from __future__ import annotations

import numpy as np
import pytest
from passes.estimator_cases import inputs_of, picture_frame, random_picture
from passes.pass_harness import STORED_AS, texture_from_image

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.texture import make_framebuffer, make_texture

SIZE = (24, 16)
TAN_Y = 0.5
RADIUS = 0.8
# As shaders/lib/shaded_pixels.glsl says: of a pixel's height.
LEAST_HEIGHT = 0.05
# As shaders/effects/own_pixels.frag writes them in eight bits.
NONE, USUAL, EDGE = 0, 128, 255
# What hangs on less is rounding's to decide.
TIE = 1e-5


def expected(picture):
    """Return the classes (height, width), row 0 at the bottom, and where they are sure."""
    width, height = SIZE
    rows, columns = np.mgrid[:height, :width]
    texel = np.stack([columns, rows], -1)
    p, n, has = picture.position(texel), picture.geometric, picture.z > 0.0
    least = LEAST_HEIGHT * picture.z * 2.0 * TAN_Y / height
    shaded, sure = np.zeros(has.shape, bool), np.ones(has.shape, bool)
    for y in (-1, 0, 1):
        for x in (-1, 0, 1):
            at = np.clip(rows + y, 0, height - 1), np.clip(columns + x, 0, width - 1)
            d = p[at] - p
            margins = (d * n).sum(-1) - least, (d * n[at]).sum(-1) - least
            margins = np.stack([*margins, RADIUS - np.linalg.norm(d, axis=-1)])
            shaded |= has[at] & (margins > 0.0).all(0)
            sure &= ~has[at] | (np.abs(margins).min(0) > TIE)
    return np.where(has, np.where(shaded, EDGE, USUAL), NONE), sure


@pytest.mark.parametrize("stride", [1, 2])
@pytest.mark.parametrize("seed", range(3))
def test_pixels_that_what_turns_away_in_front_may_shade_are_edges(gl, shaders, seed, stride):
    picture = random_picture(seed, SIZE, (TAN_Y * SIZE[0] / SIZE[1], TAN_Y), has_back=False)
    images = inputs_of(picture)
    textures = {
        f"t_{name}": texture_from_image(gl, images[name], STORED_AS.get(name, "f4"))
        for name in ("z_vs", "normals_vs")
    }
    classes = make_texture(gl, SIZE, 4, "nu1")
    target = make_framebuffer(gl, [classes])
    frame = picture_frame(SIZE, TAN_Y)
    uniforms = {**frame.view.uniforms(), "u_radius": RADIUS, "u_receiver_stride": stride}
    program = shaders.fullscreen("effects/own_pixels.frag", {})
    draw_fullscreen(gl, program, target, uniforms, textures)
    texels = np.frombuffer(classes.read(), np.uint8).reshape(*SIZE[::-1], 4)
    found = texels[..., 0]
    wanted, sure = expected(picture)
    asked = np.zeros(wanted.shape, bool)
    asked[::stride, ::stride] = True
    assert set(wanted[asked]) == {NONE, USUAL, EDGE}
    assert sure.mean() > 0.95
    np.testing.assert_array_equal(found[sure & asked], wanted[sure & asked])
    assert not texels[~asked].any()
    codes = texels[..., 1:3] / 127.0 - 1.0
    lower = 1.0 - np.abs(codes).sum(-1, keepdims=True)
    folded = codes - np.copysign(np.maximum(-lower, 0.0), codes)
    normals = np.concatenate([folded, lower], -1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    shown = asked & (wanted != NONE)
    # Half a step of 127 is .3 degrees, two and a half times as many where the octahedron is steep.
    assert ((normals * picture.geometric).sum(-1)[shown] > np.cos(np.radians(1.0))).all()
