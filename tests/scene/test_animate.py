"""Scenes in time: motions of objects and lights."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ssdo_gl.scene.animate import scene_at
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry import shapes
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.lights import DirectionalLight, Light, PointLight, RectangleLight, SpotLight
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.motion import Motion
from ssdo_gl.scene.scene import Scene

QUARTER = Motion(orbit=(0.0, 90.0, 0.0))  # a quarter turn about +y each second
WHITE = (1.0, 1.0, 1.0)


def scene(*lights: Light, motion: Motion | None = None) -> Scene:
    return Scene(
        (shapes.box(),),
        (Material(),),
        (SceneObject(0, 0, motion=motion), SceneObject(0, 0)),
        Camera((0.0, 0.0, 5.0), (0.0, 0.0, 0.0)),
        lights=lights,
    )


def test_a_still_scene_is_returned_as_it_is() -> None:
    still = scene(PointLight((1.0, 0.0, 0.0), WHITE))
    assert scene_at(still, 3.0) is still


def test_objects_move_and_others_are_shared() -> None:
    moving = scene(motion=Motion(sway=(0.0, 2.0, 0.0), period=4.0))
    later = scene_at(moving, 1.0)
    assert later.objects[0].world_from_object[0, :3, 3] == pytest.approx([0.0, 2.0, 0.0])
    assert later.objects[1] is moving.objects[1]
    assert later.meshes is moving.meshes
    # Times do not add up: the scene at rest is never changed.
    again = scene_at(moving, 1.0)
    assert np.array_equal(again.objects[0].world_from_object, later.objects[0].world_from_object)


def test_time_zero_is_rest() -> None:
    moving = scene(motion=Motion(spin=(10.0, 20.0, 30.0), orbit=(1.0, 2.0, 3.0)))
    assert scene_at(moving, 0.0).objects[0].world_from_object == pytest.approx(
        moving.objects[0].world_from_object
    )


@pytest.mark.parametrize(
    ("light", "field", "expected"),
    [
        (PointLight((1.0, 0.5, 0.0), WHITE), "position", (0.0, 0.5, -1.0)),
        (DirectionalLight((1.0, 0.0, 0.0), WHITE), "direction", (0.0, 0.0, -1.0)),
        (SpotLight((2.0, 0.0, 0.0), (0.0, 0.0, 1.0), WHITE), "position", (0.0, 0.0, -2.0)),
        (SpotLight((2.0, 0.0, 0.0), (0.0, 0.0, 1.0), WHITE), "direction", (1.0, 0.0, 0.0)),
        (RectangleLight((1, 0, 0), (1, 0, 0), (0, 1, 0), WHITE), "corner", (0.0, 0.0, -1.0)),
        (RectangleLight((1, 0, 0), (1, 0, 0), (0, 1, 0), WHITE), "edge_u", (0.0, 0.0, -1.0)),
        (RectangleLight((1, 0, 0), (1, 0, 0), (0, 1, 0), WHITE), "edge_v", (0.0, 1.0, 0.0)),
    ],
)
def test_lights_turn_with_their_motion(
    light: Light, field: str, expected: tuple[float, float, float]
) -> None:
    moving = scene(dataclasses.replace(light, motion=QUARTER))
    later = scene_at(moving, 1.0).lights[0]
    assert getattr(later, field) == pytest.approx(expected, abs=1e-12)


def test_spin_turns_about_the_pivot() -> None:
    motion = Motion(spin=(0.0, 0.0, 180.0), pivot=(1.0, 0.0, 0.0))
    later = scene_at(scene(motion=motion), 1.0)
    moved = later.objects[0].world_from_object[0] @ [0.0, 0.0, 0.0, 1.0]
    assert moved[:3] == pytest.approx([2.0, 0.0, 0.0], abs=1e-12)
