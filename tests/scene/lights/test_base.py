"""What every kind of light promises."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ssdo_gl import math3d
from ssdo_gl.scene.lights import (
    KINDS,
    DirectionalLight,
    Form,
    Light,
    PointLight,
    RectangleLight,
    SpotLight,
)

LIGHTS: tuple[Light, ...] = (
    PointLight((1.0, 2.0, 3.0), (4.0, 5.0, 6.0)),
    SpotLight((1.0, 2.0, 3.0), (0.0, -1.0, 0.0), (4.0, 5.0, 6.0)),
    DirectionalLight((0.0, -1.0, 0.0), (4.0, 5.0, 6.0)),
    RectangleLight((0.0, 2.0, 3.0), (2.0, 0.0, 0.0), (0.0, 0.0, 1.0), (4.0, 5.0, 6.0)),
)
POINTS = np.random.default_rng(1).uniform(-2.0, 1.0, (200, 3))
NORMALS = math3d.normalized(np.random.default_rng(2).normal(size=(200, 3)))

each_kind = pytest.mark.parametrize("light", LIGHTS, ids=lambda light: light.kind)


def test_every_kind_is_here() -> None:
    assert {type(light) for light in LIGHTS} == set(KINDS.values())


@each_kind
def test_brightness_is_read_and_written_by_one_name(light: Light) -> None:
    assert light.emitted == (4.0, 5.0, 6.0)
    assert light.power == 6.0
    brighter = light.with_emitted((8.0, 5.0, 0.0))
    assert brighter.emitted == (8.0, 5.0, 0.0)
    assert brighter.with_emitted(light.emitted) == light
    assert "W" in light.emitted_unit


@each_kind
def test_moving_there_and_back(light: Light) -> None:
    place = light.place
    moved = light.moved_to((7.0, 8.0, 9.0))
    if light.form is Form.PARALLEL:
        assert (place, moved) == (None, light)
    else:
        assert place is not None
        assert moved.place == (7.0, 8.0, 9.0)
        assert moved.moved_to(place) == light


@each_kind
def test_a_scene_that_turns_with_its_light_looks_the_same(light: Light) -> None:
    matrix = math3d.translation([3.0, -1.0, 2.0]) @ math3d.rotation_euler([20.0, 130.0, -70.0])
    before = light.irradiance_at(POINTS, NORMALS)
    moved = light.moved(matrix)
    after = moved.irradiance_at(math3d.transform_points(matrix, POINTS), NORMALS @ matrix[:3, :3].T)
    assert before.max() > 0.0
    np.testing.assert_allclose(after, before, rtol=1e-9, atol=1e-12)


@each_kind
@pytest.mark.parametrize("factor", [1e-3, 7.0])
def test_a_scene_that_grows_with_its_light_looks_the_same(light: Light, factor: float) -> None:
    before = light.irradiance_at(POINTS, NORMALS)
    after = light.scaled(factor).irradiance_at(factor * POINTS, NORMALS)
    np.testing.assert_allclose(after, before, rtol=1e-9)


@each_kind
def test_surfaces_are_no_brighter_than_senders_can_be(light: Light) -> None:
    """Of surfaces at least 1 away; irradiance here is the mean over colours."""
    place = light.place
    away = np.full(len(POINTS), 1.0) if place is None else np.linalg.norm(POINTS - place, axis=1)
    far = away >= 1.0
    assert far.any()
    brightest = light.irradiance_at(POINTS[far], NORMALS[far]).max() / np.pi
    assert brightest <= light.sender_radiance(1.0)


@each_kind
def test_all_its_light_comes_from_its_outline(light: Light) -> None:
    outline = light.outline()
    if outline is None:
        assert light.form is Form.PARALLEL
    else:
        assert light.place is not None
        np.testing.assert_allclose(outline.mean(axis=0), light.place)


@each_kind
def test_without_its_shadow_it_needs_no_map(light: Light) -> None:
    assert light.face_count == light.map_faces >= 1
    bare = light.without_shadow()
    assert (bare.shadow, bare.face_count) == ("none", 0)
    assert dataclasses.replace(bare, shadow="map") == light
