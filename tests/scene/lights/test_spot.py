"""Spot lights: their cone, in light, reach and shadow map."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.scene.lights import SpotLight

LIGHT = SpotLight((0.0, 2.0, 0.0), (0.0, -1.0, 0.0), (3.0, 6.0, 9.0), 20.0, 40.0)


def reaches(light: SpotLight, point: tuple[float, float, float], radius: float = 0.0) -> bool:
    return light.can_reach(np.array([point]), np.array([radius]), lambda axis: np.zeros(1))


def test_cone_ends_at_the_outer_angle() -> None:
    edge = 2.0 * np.tan(np.radians(40.0))
    assert reaches(LIGHT, (edge - 1e-4, 0.0, 0.0))
    assert not reaches(LIGHT, (edge + 1e-4, 0.0, 0.0))
    # A sphere is reached as soon as its edge is.
    off = 2e-2 * np.cos(np.radians(40.0))
    assert reaches(LIGHT, (edge + 2e-2, 0.0, 0.0), 1.001 * off)
    assert not reaches(LIGHT, (edge + 2e-2, 0.0, 0.0), 0.999 * off)
    assert reaches(LIGHT, (0.0, 2.1, 0.0), 0.2)


def test_shader_row_ramps_between_the_angles() -> None:
    cosine, slope = LIGHT.shader_row().numbers
    ramp = [(np.cos(np.radians(a)) - cosine) * slope for a in (20.0, 40.0)]
    assert ramp == pytest.approx([1.0, 0.0])


def test_rays_choose_it_by_its_share_of_directions() -> None:
    assert LIGHT.emitter(np.zeros(3), 1.0).power == pytest.approx(
        6.0 * 2.0 * np.pi * (1.0 - np.cos(np.radians(40.0)))
    )


@pytest.mark.parametrize(("outer", "faces", "half"), [(40.0, 1, 0.8390996), (70.0, 5, 1.0)])
def test_wide_cones_take_a_half_cube(outer: float, faces: int, half: float) -> None:
    light = SpotLight((0, 0, 0), (0, 0, -1), (1, 1, 1), 10.0, outer)
    view = light.shadow_view(lambda axes: (np.zeros(3), np.ones(3)), 1)
    assert light.map_faces == faces
    assert view.half_size == pytest.approx((half, half))
