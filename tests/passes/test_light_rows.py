"""Lights as the numbers that shaders read, made relative to the camera in float64."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl import math3d
from ssdo_gl.graph.frame import FrameView
from ssdo_gl.passes.light_rows import light_rows
from ssdo_gl.scene.lights import (
    DirectionalLight,
    PointLight,
    RectangleLight,
    SpotLight,
    kind_number,
)
from ssdo_gl.scene.shadow_frames import shadow_frames

OFFSET = np.array([1e6, -2e6, 3e6])
LIGHTS = (
    PointLight(tuple(OFFSET + (1, 2, 3)), (4, 5, 6)),
    SpotLight(tuple(OFFSET), (0.0, 0.6, -0.8), (4, 5, 6), 20.0, 50.0, shadow="none"),
    DirectionalLight((0.0, 0.6, -0.8), (4, 5, 6), shadow="ssdo"),
    RectangleLight(tuple(OFFSET), (2, 0, 0), (0, 0, 4), (4, 5, 6), two_sided=True),
)


@pytest.fixture
def view():
    rotation = math3d.rotation_euler([20.0, -30.0, 10.0])[:3, :3]
    return FrameView((64, 48), OFFSET + (0.5, 0.25, 0.125), rotation, (0.8, 0.6), 0.1, 10.0)


@pytest.fixture
def rows(view):
    frames = shadow_frames(LIGHTS, lambda axes: (-np.ones(3), np.ones(3)), 2)
    return light_rows(LIGHTS, frames, view)


def test_kinds_shadows_and_powers(rows):
    assert rows.shape == (4, 9, 4)
    np.testing.assert_array_equal(rows[:, 0, 0], [kind_number(light) for light in LIGHTS])
    assert len(set(rows[:, 0, 0])) == len(LIGHTS)
    np.testing.assert_array_equal(rows[:, 0, 1], [1, 0, 2, 1])
    np.testing.assert_array_equal(rows[:, 0, 3], [0, 0, 0, 1])
    np.testing.assert_array_equal(rows[:, 2, :3], np.tile([4, 5, 6], (4, 1)))


def test_places_are_exact_however_far_out(rows, view):
    """1e6 from the origin: float32 differences would be multiples of 0.06."""
    turn = view.view_from_world
    np.testing.assert_allclose(rows[0, 1, :3], turn @ [0.5, 1.75, 2.875], atol=1e-9)
    np.testing.assert_allclose(rows[1, 1, :3], turn @ [-0.5, -0.25, -0.125], atol=1e-9)
    np.testing.assert_allclose(rows[2, 1, :3], turn @ [0.0, -0.6, 0.8], atol=1e-15)
    np.testing.assert_allclose(rows[3, 1, :3], turn @ [0.5, -0.25, 1.875], atol=1e-9)
    np.testing.assert_allclose(rows[3, 3, :3], turn @ [1, 0, 0], atol=1e-15)
    np.testing.assert_allclose(rows[3, 4, :3], turn @ [0, 0, 2], atol=1e-15)


def test_spot_cone(rows, view):
    cos_inner, cos_outer = np.cos(np.radians([20.0, 50.0]))
    assert rows[1, 1, 3] == pytest.approx(1.0 - cos_outer)
    assert rows[1, 2, 3] == pytest.approx(1.0 / (cos_inner - cos_outer))
    np.testing.assert_allclose(rows[1, 3, :3], view.view_from_world @ [0.0, 0.6, -0.8], atol=1e-15)


def test_shadow_maps_of_lights_that_have_one(rows, view):
    for row, light in zip(rows, LIGHTS, strict=True):
        axes = row[5:8, :3]
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-14)
        assert (row[8, 3] > 0) == (light.shadow == "map")
    # The rectangle shines along edge_u x edge_v = -y; its map looks from its centre.
    np.testing.assert_allclose(rows[3, 7, :3], view.view_from_world @ [0, -1, 0], atol=1e-14)
    np.testing.assert_allclose(rows[3, 8, :3], rows[3, 1, :3], atol=1e-9)
    assert rows[3, 0, 2] == 2
    assert rows[3, 8, 3] == 6


def test_no_lights_no_rows(view):
    assert light_rows((), [], view).shape == (0, 9, 4)
