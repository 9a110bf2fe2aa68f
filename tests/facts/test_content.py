"""What a scene contains, found from its objects and lights alone."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ssdo_gl.facts.content import LightContent, analyse
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
    soft = LightContent("ssdo", True, is_soft=True)
    assert through.lights == (soft, LightContent("map", False))
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
    assert not content.has_emission and not content.has_albedo


def test_emission_that_a_light_delivers_is_told_from_other_emission():
    lamp = Material(emission=RED)
    body = scene_with(materials=(lamp,), objects=(SceneObject(0, 0, light=0),), lights=(PANEL,))
    assert analyse(body).has_emission and not analyse(body).has_unlit_emission
    assert not analyse(body).has_glow and not analyse(body).has_stand_ins
    alone = analyse(scene_with(materials=(lamp,)))
    assert alone.has_unlit_emission and alone.has_glow
    shown = analyse(scene_with(materials=(Material(albedo=RED, is_unlit=True),)))
    assert shown.has_unlit_emission and not shown.has_glow


@pytest.mark.parametrize("shadow", ["map", "none"])
def test_sample_rectangles_are_told_from_lights_that_are_their_bodies(shadow):
    lamp = Material(emission=RED)
    within = dataclasses.replace(PANEL, shadow=shadow, visible=False)
    body = scene_with(
        materials=(lamp,), objects=(SceneObject(0, 0, light=0),), lights=2 * (within,)
    )
    assert analyse(body).has_stand_ins == (shadow == "map")


def test_solids():
    assert not analyse(scene_with()).has_closed_meshes
    assert analyse(scene_with(mesh=shapes.box())).has_closed_meshes


@pytest.mark.parametrize(
    ("environment", "kind"),
    [
        (None, "none"),
        (ConstantEnvironment(BLACK), "none"),
        (ConstantEnvironment((0.0, 0.0, 1e-6)), "constant"),
        (GradientEnvironment(BLACK, BLACK, BLACK), "none"),
        (GradientEnvironment(BLACK, BLACK, (0.0, 0.0, 1e-6)), "gradient"),
        (MapEnvironment(np.zeros((2, 4, 3), np.float32)), "map"),
    ],
)
def test_black_is_no_environment(environment, kind):
    assert analyse(scene_with(environment=environment)).environment == kind
