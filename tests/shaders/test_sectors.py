"""Slices as 32 directions: bits, and the share of a slice that lies before a direction."""

from __future__ import annotations

import numpy as np
import pytest
from oracle import slices
from shaders.harness import evaluate

INCLUDES = ["screen_space/sectors.glsl"]
DEFINES = {"IS_OPEN": 0, "HAS_BACK_LAYER": 0, "DIRECTION_COUNT": 1, "STEP_COUNT": 1}
# Sums of products of sines, cosines and an angle, each good to 2e-7, over totals from 1 to 1.6.
SHARE_TOLERANCE = 2e-6


def test_bits_are_counted(gl, shaders):
    rng = np.random.default_rng(0)
    words = np.concatenate(
        [[0, 1, 2**31, 2**32 - 1], rng.integers(0, 2**32, 2000), 1 << np.arange(32)]
    ).astype(np.uint32)
    found = evaluate(gl, shaders, INCLUDES, "bit_count(words)", {"words": words},
                     output_dtype="i4", defines=DEFINES)  # fmt: skip
    np.testing.assert_array_equal(found[:, 0], [int(w).bit_count() for w in words])


def test_lowest_bits_from_none_to_all(gl, shaders):
    """32 of them without a shift by 32, which is undefined."""
    count = np.arange(33)
    found = evaluate(gl, shaders, INCLUDES, "lowest_bits(count)", {"count": count},
                     output_dtype="u4", defines=DEFINES)  # fmt: skip
    np.testing.assert_array_equal(found[:, 0], [(1 << int(n)) - 1 for n in count])


def shares(gl, shaders, gamma, angle):
    xy = np.stack([np.sin(angle), np.cos(angle)], 1)
    body = "share_before(sectors_of(Slice(vec3(0.0), gamma, 1.0), 0.0), xy)"
    inputs = {"gamma": gamma, "xy": xy}
    return evaluate(gl, shaders, INCLUDES, body, inputs, defines=DEFINES)[:, 0]


@pytest.mark.parametrize("gamma", [-1.57, -0.7, 0.0, 0.3, 1.2, 1.57])
def test_share_is_the_integral_of_the_weight(gl, shaders, gamma):
    """Of cos(t - gamma) |sin t|, by the midpoint rule, from end to end."""
    edges = gamma + np.linspace(-np.pi / 2.0, np.pi / 2.0, 20001)
    t = 0.5 * (edges[1:] + edges[:-1])
    weight = np.cos(t - gamma) * np.abs(np.sin(t))
    expected = np.concatenate([[0.0], np.cumsum(weight)]) / weight.sum()
    inner = slice(10, -10)
    found = shares(gl, shaders, np.full(edges.shape, gamma), edges)
    np.testing.assert_allclose(found[inner], expected[inner], rtol=0.0, atol=SHARE_TOLERANCE)
    twin = slices.share_before(np.full(edges.shape, gamma), np.sin(edges), np.cos(edges))
    np.testing.assert_allclose(twin[inner], expected[inner], rtol=0.0, atol=1e-7)


def test_beyond_the_hemisphere_is_all_or_nothing(gl, shaders):
    gamma = np.array([0.3, 0.3, -0.3, -0.3, 1.5, 1.5])
    angle = gamma + np.array([1.6, -1.6, 1.7, -1.7, 1.58, -1.58])
    np.testing.assert_array_equal(shares(gl, shaders, gamma, angle), [1, 0, 1, 0, 1, 0])
