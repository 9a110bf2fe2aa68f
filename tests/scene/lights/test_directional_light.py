"""Directional lights: the same everywhere, with a map around the scene."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ssdo_gl import math3d
from ssdo_gl.scene.lights import DirectionalLight

LIGHT = DirectionalLight((0.0, -0.6, 0.8), (3.0, 6.0, 9.0))


def test_irradiance_is_the_cosine_everywhere() -> None:
    up = np.tile([0.0, 1.0, 0.0], (2, 1))
    points = np.array([[0.0, 0.0, 0.0], [1e6, 5.0, -1e3]])
    assert LIGHT.irradiance_at(points, up) == pytest.approx([3.6, 3.6])


def test_shaders_and_rays_get_the_direction_towards_it() -> None:
    assert LIGHT.shader_row().place == pytest.approx([0.0, 0.6, -0.8])
    own = LIGHT.emitter(np.array([5.0, 5.0, 5.0]), 3.0)
    assert own.place == pytest.approx([0.0, 0.6, -0.8])
    assert own.emitted == pytest.approx([3.0, 6.0, 9.0])


def test_spread_is_the_tangent_of_half_the_angle() -> None:
    sun = dataclasses.replace(LIGHT, angle=20.0)
    assert LIGHT.spread == 0.0
    assert sun.spread == pytest.approx(0.17632698)
    assert sun.shader_row().numbers[0] == sun.spread == sun.emitter(np.zeros(3), 3.0).second_axis[0]


def test_map_encloses_the_scene() -> None:
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (0, 2) for z in (-5, 5)], float)

    def bounds_of(axes):
        along = corners @ axes.T
        return along.min(axis=0), along.max(axis=0)

    view = LIGHT.shadow_view(bounds_of, 1)
    seen = (corners - view.origin_ws) @ math3d.frame_from_z(LIGHT.direction)
    assert np.all(np.abs(seen[:, :2]) < view.half_size)
    assert np.all((seen[:, 2] > 0.0) & (seen[:, 2] < view.depth))
