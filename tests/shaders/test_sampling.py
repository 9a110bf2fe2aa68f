"""Directions on the hemisphere: unit length, the right density, no degenerate frame."""

from __future__ import annotations

import numpy as np
import pytest
from oracle import closed_forms, screen_space
from shaders.harness import evaluate

INCLUDES = ["lib/sampling.glsl"]
# Float32 sums of three squares of numbers up to 1, through sin and cos good to 6.3e-8.
UNIT_TOLERANCE = 5e-7
COUNT = 1 << 16
# Evenly spread points miss the area of a smooth region by about COUNT^(-3/4) = 2.4e-4.
SHARE_TOLERANCE = 3e-4


def square():
    """Points of the R2 sequence, which is even in every direction, unlike a grid."""
    return screen_space.kronecker_points(np.arange(COUNT), (1 << 31,) * 3)[:, :2]


def directions(gl, shaders, name):
    return evaluate(gl, shaders, INCLUDES, f"{name}(u)", {"u": square()}, 3).astype(np.float64)


def normals():
    rng = np.random.default_rng(3)
    n = rng.normal(size=(500, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    small = np.array([1e-3, -1e-3, 1e-7, -1e-7, 1e-20, -1e-20, 0.0, -0.0])
    grazing = np.stack([np.ones_like(small), small * 0.0, small], 1)
    polar = np.stack([small, small[::-1], -np.ones_like(small)], 1)
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    n = np.concatenate([n, grazing, polar, axes])
    return n / np.linalg.norm(n, axis=1, keepdims=True)


def test_frame_is_a_rotation_onto_every_normal(gl, shaders):
    """Around the pole z = -1, too, where a naive frame divides by zero."""
    n = normals().astype(np.float32)
    columns = [
        evaluate(gl, shaders, INCLUDES, f"frame_from_z(n)[{i}]", {"n": n}, 3) for i in range(3)
    ]
    frame = np.stack(columns, -1).astype(np.float64)
    gram = np.einsum("nij,nik->njk", frame, frame)
    np.testing.assert_allclose(gram, np.broadcast_to(np.eye(3), gram.shape), atol=UNIT_TOLERANCE)
    np.testing.assert_allclose(np.linalg.det(frame), 1.0, atol=UNIT_TOLERANCE)
    np.testing.assert_array_equal(frame[..., 2], n)
    np.testing.assert_allclose(frame, screen_space.frame_from_z(n), atol=UNIT_TOLERANCE)


@pytest.mark.parametrize("name", ["cosine_hemisphere", "uniform_hemisphere"])
def test_directions_are_unit_and_above_the_plane(gl, shaders, name):
    corners = np.array([[0.0, 0.0], [0.0, 1.0], [1.0 - 2.0**-24, 0.5], [0.5, 1.0 - 2.0**-24]])
    u = np.concatenate([square(), corners])
    w = evaluate(gl, shaders, INCLUDES, f"{name}(u)", {"u": u}, 3).astype(np.float64)
    np.testing.assert_allclose(np.linalg.norm(w, axis=1), 1.0, atol=UNIT_TOLERANCE)
    assert w[:, 2].min() > 0.0
    twin = getattr(screen_space, name)(u.astype(np.float32).astype(np.float64))
    np.testing.assert_allclose(w, twin, atol=UNIT_TOLERANCE)


@pytest.mark.parametrize("k", [0.05, 0.25, 0.5, 0.9])
@pytest.mark.parametrize("azimuth", [0.0, 0.7, 2.5])
def test_density_gives_the_closed_forms_of_a_wall(gl, shaders, k, azimuth):
    """The share of directions that meet a wall at distance k R: A1 and A2."""
    toward = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    cosine = np.mean(directions(gl, shaders, "cosine_hemisphere") @ toward >= k)
    uniform = np.mean(directions(gl, shaders, "uniform_hemisphere") @ toward >= k)
    assert cosine == pytest.approx(closed_forms.corner_occlusion(k), abs=SHARE_TOLERANCE)
    assert uniform == pytest.approx(closed_forms.corner_occlusion_uniform(k), abs=SHARE_TOLERANCE)
