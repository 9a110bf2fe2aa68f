"""What a scene contains, found from its objects and lights alone."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ssdo_gl.planning.content import LightContent, analyse, simplest_environment
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment.environment_kinds import (
    ConstantEnvironment,
    GradientEnvironment,
    MapEnvironment,
)
from ssdo_gl.scene.geometry import shapes
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.lights import DirectionalLight, PointLight, RectangleLight, SpotLight
from ssdo_gl.scene.material import Material, Texture
from ssdo_gl.scene.motion import Motion
from ssdo_gl.scene.scene import Scene

BLACK, GREY, RED = (0.0, 0.0, 0.0), (0.5, 0.5, 0.5), (0.6, 0.0, 0.0)
POINT = PointLight((0.0, 2.0, 0.0), GREY)
SPOT = SpotLight((0.0, 2.0, 0.0), (0.0, -1.0, 0.0), GREY)
SUN = DirectionalLight((0.0, -1.0, 0.0), GREY)
PANEL = RectangleLight((0, 2, 0), (1, 0, 0), (0, 0, 1), GREY)
LIGHTS = (POINT, SPOT, SUN, PANEL)
PLAIN = (Material(),)


def scene_with(*, materials=PLAIN, lights=(), environment=None, objects=None, mesh=None):
    objects = objects or tuple(SceneObject(0, i) for i in range(len(materials)))
    meshes = (mesh or shapes.quad(),)
    return Scene(meshes, materials, objects, Camera((0, 0, 3), (0, 0, 0)), lights, environment)


def off(light):
    key = {RectangleLight: "radiance", DirectionalLight: "irradiance"}.get(type(light), "intensity")
    return dataclasses.replace(light, **{key: BLACK})


@pytest.mark.parametrize("light", LIGHTS)
def test_a_light_counts_unless_it_is_off(light):
    assert light.power == 0.5
    assert analyse(scene_with(lights=(light,))).has_direct_lights
    dark = analyse(scene_with(lights=(off(light),)))
    assert not dark.has_lights and not dark.has_direct_lights
    assert dark.lights[0].is_on is False


def test_the_shadow_of_a_light_says_how_it_arrives():
    through = analyse(scene_with(lights=(dataclasses.replace(PANEL, shadow="ssdo"), off(SPOT))))
    assert through.has_ssdo_lights and not through.has_direct_lights
    assert through.lights == (LightContent("ssdo", True), LightContent("map", False))
    plain = analyse(scene_with(lights=(dataclasses.replace(POINT, shadow="none"),)))
    assert plain.has_direct_lights and plain.lights[0].shadow == "none"


def test_a_light_that_is_off_does_not_count_as_ssdo_light():
    dark = dataclasses.replace(off(SPOT), shadow="ssdo")
    assert not analyse(scene_with(lights=(dark, POINT))).has_ssdo_lights


def test_surfaces():
    assert analyse(scene_with()).has_albedo
    assert not analyse(scene_with(materials=(Material(albedo=BLACK),))).has_albedo
    # One component of one surface is enough.
    dim = Material(albedo=(0.0, 1e-6, 0.0))
    assert analyse(scene_with(materials=(Material(albedo=BLACK), dim))).has_albedo


def test_a_material_that_nothing_wears_does_not_count():
    lamp = Material(emission=RED, albedo_texture=Texture(np.zeros((1, 1, 4), np.uint8)))
    unused = scene_with(materials=(Material(albedo=BLACK), lamp), objects=(SceneObject(0, 0),))
    content = analyse(unused)
    assert not content.has_emission and not content.has_textures and not content.has_albedo


def test_emission_that_a_light_delivers_is_told_from_other_emission():
    lamp = Material(emission=RED)
    body = scene_with(materials=(lamp,), objects=(SceneObject(0, 0, light=0),), lights=(PANEL,))
    assert analyse(body).has_emission and not analyse(body).has_unlit_emission
    assert analyse(scene_with(materials=(lamp,))).has_unlit_emission


def test_textures_solids_and_motion():
    plain = analyse(scene_with())
    assert not (plain.has_textures or plain.has_closed_meshes or plain.has_motion)
    texture = Texture(np.zeros((1, 1, 4), np.uint8))
    assert analyse(scene_with(materials=(Material(emission_texture=texture),))).has_textures
    assert analyse(scene_with(mesh=shapes.box())).has_closed_meshes
    swaying = dataclasses.replace(POINT, motion=Motion(sway=(1, 0, 0)))
    assert analyse(scene_with(lights=(swaying,))).has_motion


def test_triangles_are_counted_with_instances():
    three = SceneObject(0, 0, np.tile(np.eye(4), (3, 1, 1)))
    assert analyse(scene_with(objects=(three,), mesh=shapes.box())).triangle_count == 36


SKY_MAP = MapEnvironment(np.full((4, 8, 3), 0.25, np.float32))
ALMOST = SKY_MAP.image.copy()
ALMOST[-1, -1, 2] += 1e-6


@pytest.mark.parametrize(
    ("environment", "kind"),
    [
        (None, "none"),
        (ConstantEnvironment(BLACK), "none"),
        (ConstantEnvironment((0.0, 0.0, 1e-6)), "constant"),
        (GradientEnvironment(BLACK, BLACK, BLACK), "none"),
        (GradientEnvironment(RED, RED, RED), "constant"),
        (GradientEnvironment(RED, RED, (0.6, 0.0, 1e-6)), "gradient"),
        (MapEnvironment(np.zeros((2, 4, 3), np.float32)), "none"),
        (SKY_MAP, "constant"),
        (MapEnvironment(ALMOST), "map"),
    ],
)
def test_the_simplest_environment_that_gives_the_same_light(environment, kind):
    content = analyse(scene_with(environment=environment))
    assert content.environment == kind
    own = {type(None): "none", ConstantEnvironment: "constant", GradientEnvironment: "gradient"}
    assert content.environment_is_simplified == (kind != own.get(type(environment), "map"))
    simple = simplest_environment(environment)
    direction = np.array([[0.0, 1.0, 0.0], [0.6, -0.8, 0.0], [0.0, 0.0, 1.0]])
    expected = np.zeros((3, 3)) if environment is None else environment.sample(direction)
    found = np.zeros((3, 3)) if simple is None else simple.sample(direction)
    np.testing.assert_array_equal(found, expected)


def test_a_map_is_looked_through_once():
    environment = MapEnvironment(np.full((4, 8, 3), 0.5, np.float32))
    first = simplest_environment(environment)
    object.__setattr__(environment, "image", None)
    assert simplest_environment(environment) == first
