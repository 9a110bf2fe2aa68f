"""The edge-aware filter brings half-size images to the frame's size."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from passes.estimator_cases import (
    inputs_of,
    picture_frame,
)
from passes.filter_harness import MEAN_TOLERANCE, TAN_Y, halves, plane, run
from passes.pass_harness import run_pass

from ssdo_gl.passes.edge_aware_filter import (
    EdgeAwareFilterPass,
    EdgeAwareFilterSettings,
    Signal,
)


@pytest.mark.parametrize("size", [(48, 36), (49, 35)])
def test_half_size_keeps_a_ramp(gl, shaders, size):
    """Bilinear between receivers, which sit on every second texel: a ramp stays one."""
    picture = plane(0.0, size)
    x = np.arange(0, size[0], 2) / 100.0
    raw = np.broadcast_to(x[None, :, None], (-(-size[1] // 2), len(x), 4))
    image = run(gl, shaders, picture, raw, scale=2)
    expected = np.arange(size[0]) / 100.0
    # At the rim the kernel is one-sided. Weights of at least 1e-3 keep all four taps in.
    inner = slice(10, size[0] - 10)
    np.testing.assert_allclose(
        image[:, inner, 0], np.broadcast_to(expected[inner], image[:, inner, 0].shape), atol=4e-5
    )


def test_half_size_keeps_a_jump_in_depth(gl, shaders):
    """The edge lies between texels 23 and 24, receivers on 22 and 24."""
    picture = dataclasses.replace(plane(), z=halves(2.0, 5.0, 1)[..., 0])
    raw = halves(0.0, 1.0, 4, (24, 18))
    image = run(gl, shaders, picture, raw, scale=2)
    expected = halves(0.0, 1.0, 4)
    # Weights relative to a footprint twice as large, and taps 1000 times weaker where
    # the edge leaves no other.
    assert np.abs(image - expected)[..., :3].max() < 1e-3


def test_ledge_thinner_than_a_receiver_takes_what_is_near(gl, shaders):
    """A surface that no half-size receiver lies on gets its neighbours' light, not a hole."""
    ledge = np.arange(48) == 23
    normal = np.where(ledge[None, :, None], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0])
    normal = np.broadcast_to(normal, (36, 48, 3))
    picture = dataclasses.replace(plane(), shading=normal)
    raw = np.full((18, 24, 4), 0.5)
    np.testing.assert_allclose(
        run(gl, shaders, picture, raw, scale=2)[..., :3], 0.5, rtol=MEAN_TOLERANCE
    )
    raw = np.full((18, 24, 1), 0.5)
    found = run(gl, shaders, picture, raw, visibility=True, holds_z=True, scale=2)
    np.testing.assert_allclose(found, 0.5, rtol=MEAN_TOLERANCE)


@pytest.mark.parametrize("visibility", [False, True])
def test_what_four_receivers_do_not_show_is_looked_for_farther(gl, shaders, visibility):
    """A wall seen through a slit as wide as a texel, between receivers that lie on bars.

    Of the wall behind, a receiver lies on the next column but one, to its right.
    """
    x = np.arange(48)
    bars = (x > 16) & (x < 26) & (x != 23)
    picture = dataclasses.replace(plane(), z=np.where(bars, 2.0, 5.0)[None].repeat(36, 0))
    raw = np.where(bars[::2], 0.0, 1.0)[None, :, None].repeat(18, 0)
    raw = raw if visibility else raw.repeat(4, 2)
    image = run(gl, shaders, picture, raw, visibility=visibility, holds_z=visibility, scale=2)
    assert np.abs(image[:, 23, : raw.shape[2]] - 1.0)[..., :3].max() < 1e-3
    # The bars, of which receivers lie beside every texel, take nothing from it.
    assert image[:, bars, 0].max() < 1e-3


def test_thin_thing_before_the_sky_finds_its_light_near_by(gl, shaders):
    """No receiver on its own column: the one at its foot, two receivers away, serves."""
    z = np.where((np.arange(48) == 23) & (np.arange(36)[:, None] < 30), 3.0, 0.0)
    z[10:14] = 3.0
    picture = dataclasses.replace(plane(), z=z)
    raw = np.full((18, 24, 4), 0.5)
    image = run(gl, shaders, picture, raw, scale=2)
    np.testing.assert_allclose(image[8:16, 23, :3], 0.5, rtol=MEAN_TOLERANCE)


def test_one_pass_serves_frames_of_any_size(gl, shaders):
    """Scratch images follow the frame."""
    render_pass = EdgeAwareFilterPass("filter", EdgeAwareFilterSettings(), Signal("raw", "smooth"))
    for size, half in (((48, 36), False), ((64, 48), True), ((48, 36), True)):
        picture = plane(0.0, size)
        images = inputs_of(picture)
        scale = 2 if half else 1
        raw = np.full((size[1] // scale, size[0] // scale, 4), 0.5)
        inputs = {"raw": raw, "z_vs": images["z_vs"], "normals_vs": images["normals_vs"]}
        found = run_pass(gl, shaders, render_pass, picture_frame(size, TAN_Y), inputs)["smooth"]
        assert found.shape == (size[1], size[0], 4)
        np.testing.assert_allclose(found[..., :3], 0.5, rtol=MEAN_TOLERANCE)
