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


def view(jitter_px=(0.0, 0.0), is_parallel=False):
    halves = ((0.0, 0.0), (3.2, 1.8)) if is_parallel else ((0.8, 0.45), (0.0, 0.0))
    return FrameView(SIZE, np.zeros(3), np.eye(3), halves[0], 0.1, 100.0, jitter_px, halves[1])


def evaluate_in(frame, gl, shaders, *arguments, **more):
    return evaluate(
        gl, shaders.choosing(frame.choices), *arguments, uniforms=frame.uniforms(), **more
    )


def random_pixels(count=500):
    rng = np.random.default_rng(1)
    texel = np.stack([rng.integers(0, n, count) for n in SIZE], 1)
    return texel, rng.uniform(0.5, 50.0, count).astype(np.float32)


EITHER = pytest.mark.parametrize("is_parallel", [False, True], ids=["pinhole", "parallel"])
JITTERED = pytest.mark.parametrize("jitter_px", [(0.0, 0.0), (0.5, -0.25)])


@JITTERED
@EITHER
def test_positions_project_onto_their_own_pixel(gl, shaders, jitter_px, is_parallel):
    """Against the projection matrix, which knows nothing of this library."""
    frame = view(jitter_px, is_parallel)
    texel, z = random_pixels()
    body = "position_vs_at(uv_of_texel(texel), z)"
    p = evaluate_in(frame, gl, shaders, INCLUDES, body, {"texel": texel, "z": z}, 3)
    np.testing.assert_array_equal(p[:, 2], -z)
    clip = np.concatenate([p, np.ones((len(p), 1))], 1) @ frame.clip_from_view.T
    pixel = (clip[:, :2] / clip[:, 3:] * 0.5 + 0.5) * SIZE
    np.testing.assert_allclose(pixel, texel + 0.5, atol=TOLERANCE * SIZE[0])
    assert np.all(np.abs(clip[:, 2] / clip[:, 3]) <= 1.0)


@JITTERED
@EITHER
def test_uv_of_position_is_the_inverse(gl, shaders, jitter_px, is_parallel):
    frame = view(jitter_px, is_parallel)
    rng = np.random.default_rng(2)
    uv = rng.uniform(-0.5, 1.5, (500, 2)).astype(np.float32)
    z = rng.uniform(1e-3, 1e4, 500)
    body = "uv_of_position_vs(position_vs_at(uv, z))"
    found = evaluate_in(frame, gl, shaders, INCLUDES, body, {"uv": uv, "z": z}, 2)
    np.testing.assert_allclose(found, uv, atol=TOLERANCE)


@JITTERED
@EITHER
def test_lines_are_straight_in_the_picture_and_end_where_they_should(
    gl, shaders, jitter_px, is_parallel
):
    """What a march relies on: places and nearness along a picture, and the way back to space."""
    frame = view(jitter_px, is_parallel)
    rng = np.random.default_rng(3)
    start = rng.uniform((-1, -1, -9), (1, 1, -1), (500, 3))
    end = rng.uniform((-1, -1, -9), (1, 1, -1), (500, 3))
    share = rng.uniform(0.0, 1.0, 500)
    inputs = {"a": start, "b": end, "s": share}
    body = """
        float from = nearness(-a.z);
        float change = nearness(-b.z) - from;
        float t = length_before(1.0, s, from, change);
        vec3 p = mix(a, b, t);
        vec2 apart = uv_of_position_vs(p) - mix(uv_of_position_vs(a), uv_of_position_vs(b), s);
        bool agree = is_nearer(-p.z * 0.999, from + s * change)
            && is_farther(-p.z * 1.001, from + s * change)
            && !is_nearer(-p.z * 1.001, from + s * change);
        vec4 slopes = frame_slopes(0.0);
        vec4 gap = frame_gaps(slopes, p);
        vec4 place = gap - frame_gaps(slopes, a) - t * frame_gap_rates(slopes, b - a);
        vec2 ndc = 2.0 * uv_of_position_vs(p) - 1.0;
        vec4 edge = gap / (gap + gap.zwxy) - 0.5 * vec4(1.0 - ndc, 1.0 + ndc);
        vec2 centre = (0.5 - 0.5 * u_jitter_ndc) * u_frame_size_px;
        vec2 px = picture_place(p, nearness(-p.z)) * px_scale() + centre;
        float off = length(px / u_frame_size_px - uv_of_position_vs(p));
        return vec4(length(apart) + off, agree ? 0.0 : 1.0, length(place), length(edge));
    """
    found = evaluate_in(frame, gl, shaders, INCLUDES, body, inputs, 4)
    np.testing.assert_allclose(found, 0.0, atol=1e-5)


@EITHER
def test_heights_and_viewing_directions(gl, shaders, is_parallel):
    frame = view(is_parallel=is_parallel)
    rng = np.random.default_rng(4)
    p = rng.uniform((-1, -1, -9), (1, 1, -1), (500, 3))
    direction = "viewing_direction(p, vec3(0.0, 0.0, -1.0))"
    body = f"vec4({direction}, pixel_height_at(-p.z) * u_frame_size_px.y)"
    found = evaluate_in(frame, gl, shaders, INCLUDES, body, {"p": p}, 4)
    unit = np.array([0.0, 0, -1]) if is_parallel else p / np.linalg.norm(p, axis=1)[:, None]
    np.testing.assert_allclose(found[:, :3], np.broadcast_to(unit, p.shape), atol=TOLERANCE)
    height = 3.6 if is_parallel else -0.9 * p[:, 2]
    np.testing.assert_allclose(found[:, 3], np.broadcast_to(height, 500), rtol=TOLERANCE)


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
