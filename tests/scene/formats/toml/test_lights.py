"""Lights and environments of scene files."""

from __future__ import annotations

import numpy as np
import pytest
from scene.fixture_types import SceneOf, Write

from ssdo_gl.math3d import transform_points
from ssdo_gl.scene.environment.environment_kinds import (
    ConstantEnvironment,
    GradientEnvironment,
    MapEnvironment,
)
from ssdo_gl.scene.lights import DirectionalLight, PointLight, RectangleLight, SpotLight
from ssdo_gl.scene.load import load_scene


def test_no_light_at_all_gets_a_sky_and_a_key_and_says_so(scene_of: SceneOf) -> None:
    result = scene_of("")
    assert isinstance(result.environment, GradientEnvironment)
    assert len(result.lights) == 1
    assert result.lights[0].name == "key light"
    assert any("soft sky" in note for note in result.notes)


def test_a_black_environment_is_a_choice(scene_of: SceneOf) -> None:
    result = scene_of('[environment]\nkind = "constant"\nradiance = [0, 0, 0]')
    assert result.environment == ConstantEnvironment((0.0, 0.0, 0.0))
    assert result.lights == ()
    assert result.notes == ()


def test_gradient_environment(scene_of: SceneOf) -> None:
    result = scene_of(
        '[environment]\nkind = "gradient"\nzenith = [1, 2, 3]\nhorizon = [4, 5, 6]\n'
        "ground = [7, 8, 9]"
    )
    assert result.environment == GradientEnvironment((1, 2, 3), (4, 5, 6), (7, 8, 9))


def test_map_environment(write: Write) -> None:
    header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n"
    file = write(
        {
            "sky.hdr": header + bytes([128, 64, 0, 129, 0, 0, 0, 0]),
            "s.toml": '[environment]\nkind = "map"\npath = "sky.hdr"\nrotation_y = 90\nscale = 3\n'
            '[[object]]\nshape = "sphere"\nradius = 1\n',
        }
    )
    environment = load_scene(file).environment
    assert isinstance(environment, MapEnvironment)
    assert environment.rotation_y == 90.0
    assert environment.name == "sky.hdr"
    # 128 and 64 of 256 at exponent 1, times the scale.
    assert environment.image.tolist() == [[[3.0, 1.5, 0.0], [0.0, 0.0, 0.0]]]


def test_point_spot_and_directional_lights(scene_of: SceneOf) -> None:
    result = scene_of(
        """
        [[light]]
        kind = "point"
        position = [1, 2, 3]
        intensity = [4, 5, 6]
        shadow = "none"
        name = "bulb"
        [[light]]
        kind = "spot"
        position = [0, 1, 0]
        direction = [0, -2, 0]
        intensity = [1, 1, 1]
        inner_angle = 10
        outer_angle = 20
        [[light]]
        kind = "directional"
        direction = [3, 0, 4]
        irradiance = [2, 2, 2]
        shadow = "ssdo"
        """
    )
    point, spot, sun = result.lights
    assert point == PointLight((1, 2, 3), (4, 5, 6), shadow="none", name="bulb")
    assert spot == SpotLight((0, 1, 0), (0, -1, 0), (1, 1, 1), 10.0, 20.0)
    assert isinstance(sun, DirectionalLight)
    assert sun.direction == pytest.approx((0.6, 0.0, 0.8))
    assert sun.shadow == "ssdo"
    assert sun.angle == 0.0


def test_angle_of_a_directional_light(scene_of: SceneOf) -> None:
    sun = """
        [[light]]
        kind = "directional"
        direction = [0, -1, 0]
        irradiance = [2, 2, 2]
        angle = """
    (light,) = scene_of(sun + "0.53").lights
    assert light == DirectionalLight((0.0, -1.0, 0.0), (2.0, 2.0, 2.0), 0.53)
    for wrong in ("90", "-1", "nan", '"wide"'):
        with pytest.raises(ValueError, match="angle"):
            scene_of(sun + wrong)


AREA = """
[[light]]
kind = "area"
corner = [0, 5, 0]
edge_u = [2, 0, 0]
edge_v = [0, 0, 3]
radiance = [7, 8, 9]
"""


def test_a_visible_area_light_has_a_body(scene_of: SceneOf) -> None:
    result = scene_of(AREA)
    (light,) = result.lights
    assert light == RectangleLight((0, 5, 0), (2, 0, 0), (0, 0, 3), (7, 8, 9))
    (body,) = [item for item in result.objects if item.light is not None]
    assert body.light == 0
    material = result.materials[body.material]
    assert (material.albedo, material.emission) == ((0, 0, 0), (7, 8, 9))
    assert not material.two_sided_emission
    mesh = result.meshes[body.mesh]
    corners = transform_points(body.world_from_object[0], mesh.positions)
    assert corners.tolist() == [[0, 5, 0], [2, 5, 0], [2, 5, 3], [0, 5, 3]]
    # Its front is the side that shines: down.
    assert (np.linalg.inv(body.world_from_object[0])[:3, :3].T @ [0, 0, 1])[1] < 0.0


def test_an_invisible_area_light_has_none(scene_of: SceneOf) -> None:
    result = scene_of(AREA + "visible = false\ntwo_sided = true\n")
    assert [item.light for item in result.objects] == [None]
    light = result.lights[0]
    assert isinstance(light, RectangleLight)
    assert light.two_sided
