"""Texels, depths and view-space positions."""

from __future__ import annotations

import numpy as np
import pytest
from shaders.harness import evaluate

from ssdo_gl.graph.frame import FrameView

INCLUDES = ["lib/space.glsl"]
SIZE = (640, 360)
# A few roundings of 6e-8 in numbers of the order of one.
TOLERANCE = 4e-7


def view(jitter_px=(0.0, 0.0)):
    return FrameView(SIZE, np.zeros(3), np.eye(3), (0.8, 0.45), 0.1, 100.0, jitter_px)


def random_pixels(count=500):
    rng = np.random.default_rng(1)
    texel = np.stack([rng.integers(0, n, count) for n in SIZE], 1)
    return texel, rng.uniform(0.5, 50.0, count).astype(np.float32)


@pytest.mark.parametrize("jitter_px", [(0.0, 0.0), (0.5, -0.25)])
def test_positions_project_onto_their_own_pixel(gl, shaders, jitter_px):
    """Against the projection matrix, which knows nothing of this library."""
    frame = view(jitter_px)
    texel, z = random_pixels()
    body = "position_vs_at(uv_of_texel(texel), z)"
    inputs = {"texel": texel, "z": z}
    p = evaluate(gl, shaders, INCLUDES, body, inputs, 3, uniforms=frame.uniforms())
    np.testing.assert_array_equal(p[:, 2], -z)
    clip = np.concatenate([p, np.ones((len(p), 1))], 1) @ frame.clip_from_view.T
    pixel = (clip[:, :2] / clip[:, 3:] * 0.5 + 0.5) * SIZE
    np.testing.assert_allclose(pixel, texel + 0.5, atol=TOLERANCE * SIZE[0])


@pytest.mark.parametrize("jitter_px", [(0.0, 0.0), (0.5, -0.25)])
def test_uv_of_position_is_the_inverse(gl, shaders, jitter_px):
    frame = view(jitter_px)
    rng = np.random.default_rng(2)
    uv = rng.uniform(-0.5, 1.5, (500, 2)).astype(np.float32)
    z = rng.uniform(1e-3, 1e4, 500)
    found = evaluate(
        gl,
        shaders,
        INCLUDES,
        "uv_of_position_vs(position_vs_at(uv, z))",
        {"uv": uv, "z": z},
        2,
        uniforms=frame.uniforms(),
    )
    np.testing.assert_allclose(found, uv, atol=TOLERANCE)


def test_texels_and_their_centres_belong_together(gl, shaders):
    frame = view()
    texel, _ = random_pixels()
    found = evaluate(
        gl,
        shaders,
        INCLUDES,
        "texel_of_uv(uv_of_texel(texel))",
        {"texel": texel},
        2,
        output_dtype="i4",
        uniforms=frame.uniforms(),
    )
    np.testing.assert_array_equal(found, texel)


def test_outside_the_frame_texels_are_outside_too(gl, shaders):
    """Truncation would pull what lies just left of the frame into its first column."""
    uv = np.array([[-1e-4, 0.5], [0.5, -1e-4], [1.0, 0.5], [0.5, 1.0], [0.0, 0.0]])
    found = evaluate(
        gl,
        shaders,
        INCLUDES,
        "texel_of_uv(uv)",
        {"uv": uv},
        2,
        output_dtype="i4",
        uniforms=view().uniforms(),
    )
    assert found.tolist() == [[-1, 180], [320, -1], [640, 180], [320, 360], [0, 0]]
