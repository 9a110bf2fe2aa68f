"""Unit vectors through the octahedral map, as they are stored: in 16 bits."""

from __future__ import annotations

import numpy as np
from oracle import analytic_pictures
from shaders.harness import evaluate

INCLUDES = ["lib/octahedral.glsl"]
# Measured over 1e6 normals with 16 + 16 bits: 0.0037 degrees at worst.
STORED_DEGREES = 0.0040
# A handful of roundings of 6e-8.
ROUNDING = 5e-7


def directions(count=20000):
    rng = np.random.default_rng(1)
    n = rng.normal(size=(count, 3))
    # On and around the folds, where a sign decides.
    fold = rng.normal(size=(200, 3))
    fold[:, 2] = np.repeat([0.0, 1e-7, -1e-7, -0.0], 50)
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    edges = np.array([[x, y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)])
    n = np.concatenate([n, fold, axes, edges[np.any(edges != 0, axis=1)]])
    return n / np.linalg.norm(n, axis=1, keepdims=True)


def degrees_between(a, b):
    a, b = a.astype(np.float64), b.astype(np.float64)
    cross = np.linalg.norm(np.cross(a, b), axis=1)
    return np.degrees(np.arctan2(cross, (a * b).sum(1)))


def test_round_trip_is_exact_to_rounding(gl, shaders):
    n = directions()
    found = evaluate(gl, shaders, INCLUDES, "oct_decode(oct_encode(n))", {"n": n}, 3)
    np.testing.assert_allclose(found, n, atol=ROUNDING)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1.0, atol=ROUNDING)


def test_codes_fit_unorm_channels_and_match_the_twin(gl, shaders):
    n = directions()
    code = evaluate(gl, shaders, INCLUDES, "oct_encode(n)", {"n": n}, 2)
    assert code.min() >= 0.0
    assert code.max() <= 1.0
    twin = analytic_pictures.oct_encode(n.astype(np.float32).astype(np.float64)).astype(np.int64)
    steps = np.rint(code.astype(np.float64) * 65535.0).astype(np.int64)
    # On the fold itself (z = +-1e-7) both halves are right, a mirrored pair of codes.
    firm = np.abs(n[:, 2]) > 1e-6
    # 1: a tie may be rounded either way.
    assert np.abs(steps - twin)[firm].max() <= 1


def test_stored_normals_keep_their_direction(gl, shaders):
    n = directions()
    code = evaluate(gl, shaders, INCLUDES, "oct_encode(n)", {"n": n}, 2)
    stored = np.rint(code * 65535.0) / 65535.0
    found = evaluate(gl, shaders, INCLUDES, "oct_decode(e)", {"e": stored}, 3)
    assert degrees_between(found, n).max() < STORED_DEGREES


def test_axes_survive_storage(gl, shaders):
    """Walls that face an axis stay exactly flat: 0 is one of the steps."""
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    code = evaluate(gl, shaders, INCLUDES, "oct_encode(n)", {"n": axes}, 2)
    stored = np.rint(code * 65535.0) / 65535.0
    found = evaluate(gl, shaders, INCLUDES, "oct_decode(e)", {"e": stored}, 3)
    # One rounding of the product that brings a step back to [-1, 1].
    np.testing.assert_allclose(found, axes, atol=1.3e-7)
