"""Spot lights: their cone, in light and shadow map."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.scene.lights import SpotLight

LIGHT = SpotLight((0.0, 2.0, 0.0), (0.0, -1.0, 0.0), (3.0, 6.0, 9.0), 20.0, 40.0)


def test_shader_row_ramps_between_the_angles() -> None:
    width, slope = LIGHT.shader_row().numbers
    ramp = [(np.cos(np.radians(a)) - 1.0 + width) * slope for a in (20.0, 40.0)]
    assert ramp == pytest.approx([1.0, 0.0])


@pytest.mark.parametrize(
    ("inner", "outer"), [(0.0, 1e-300), (0.0, 1e-9), (40.0 - 1e-13, 40.0), (40.0, 40.0)]
)
def test_shader_row_of_the_narrowest_is_finite_in_float32(inner: float, outer: float) -> None:
    light = SpotLight((0, 0, 0), (0, 0, -1), (1, 1, 1), inner, outer)
    numbers = np.float32(light.shader_row().numbers)
    assert np.all(np.isfinite(numbers))
    # The ramp from the axis to the rim is not lost, nor does it become nothing at all.
    assert numbers[1] * numbers[0] >= 1.0 or outer < 1e-6
    assert np.isfinite(light.emitter(np.zeros(3), 1.0).second_axis).all()


@pytest.mark.parametrize(
    ("spot", "inner", "outer"),
    [
        ({}, 0.0, 45.0),
        ({"outerConeAngle": 1e-12}, 0.0, 0.01),
        ({"outerConeAngle": np.pi / 2, "innerConeAngle": np.pi / 2}, 0.999 * 89.9, 89.9),
    ],
)
def test_angles_of_gltf_are_brought_into_range(spot, inner: float, outer: float) -> None:
    light = SpotLight.from_gltf({"spot": spot}, (0, 0, 0), (0, 0, -1), (1, 1, 1), "")
    assert (light.inner_angle, light.outer_angle) == pytest.approx((inner, outer))


def test_angles_of_gltf_are_finite() -> None:
    with pytest.raises(ValueError, match="must be finite"):
        SpotLight.from_gltf(
            {"spot": {"innerConeAngle": np.nan}}, (0, 0, 0), (0, 0, -1), (1, 1, 1), ""
        )


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
