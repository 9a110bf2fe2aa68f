"""Framebuffers cleared in part, where the rest is not read."""

from __future__ import annotations

import numpy as np

from ssdo_gl.gpu.clear import clear_last_in
from ssdo_gl.gpu.texture import make_texture


def test_the_last_attachment_is_cleared_in_a_part_and_the_others_whole(gl):
    textures = [make_texture(gl, (6, 4), 4, "f4") for _ in range(3)]
    depth = gl.depth_texture((6, 4))
    target = gl.framebuffer(textures, depth)
    target.clear(1.0, 2.0, 3.0, 4.0, depth=0.25)
    masks = target.color_mask
    clear_last_in(target, (1, 2, 3, 1))
    first, second, last = (
        np.frombuffer(texture.read(), np.float32).reshape(4, 6, 4) for texture in textures
    )
    assert not first.any() and not second.any()
    wanted = np.broadcast_to(np.array([1.0, 2.0, 3.0, 4.0], np.float32), (4, 6, 4)).copy()
    wanted[2, 1:4] = 0.0
    np.testing.assert_array_equal(last, wanted)
    steps = np.frombuffer(depth.read(), np.float32)
    assert np.all(steps == 1.0)
    assert target.color_mask == masks and target.depth_mask
