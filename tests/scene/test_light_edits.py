"""Lights changed in the window, and the bodies that stand for them in the picture."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from ssdo_gl import math3d
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry import shapes
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.light_edits import (
    moved_lights,
    new_light,
    with_added_light,
    with_lights,
    without_light,
)
from ssdo_gl.scene.lights import KINDS, Light, PointLight, RectangleLight
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene
from ssdo_gl.window.animation_clock import STEP_SECONDS, Clock


@pytest.fixture(scope="module")
def room() -> Scene:
    return load_scene("cornell_meso")


def bodies(scene: Scene) -> list[int]:
    return [i for i, item in enumerate(scene.objects) if item.light is not None]


def test_unchanged_lights_change_nothing(room: Scene) -> None:
    same = with_lights(room, room.lights, [True] * len(room.lights))
    assert same.objects == room.objects
    assert same.materials == room.materials


def test_body_of_a_light_follows_it(room: Scene) -> None:
    assert bodies(room), "the room must have a light that is seen"
    index = room.objects[bodies(room)[0]].light
    assert index is not None
    light = room.lights[index]
    place = light.place
    assert place is not None
    lights = list(room.lights)
    brighter = light.with_emitted((1.0, 2.0, 3.0))
    lights[index] = brighter.moved_to((place[0] + 0.5, place[1], place[2]))
    edited = with_lights(room, lights, [True] * len(lights))
    for i in range(len(room.objects)):
        before, after = room.objects[i], edited.objects[i]
        if before.light != index:
            assert after is before
            continue
        shift = after.world_from_object - before.world_from_object
        assert np.allclose(shift[:, :3, 3], (0.5, 0.0, 0.0))
        emission = edited.materials[after.material].emission
        assert emission == pytest.approx((1.0, 2.0, 3.0))
    # What the light's body was made of stays for whatever else is made of it.
    assert edited.materials[: len(room.materials)] == room.materials


def test_light_that_is_off_shines_nowhere_and_comes_back(room: Scene) -> None:
    off = with_lights(room, room.lights, [False] * len(room.lights))
    assert all(light.emitted == (0.0, 0.0, 0.0) for light in off.lights)
    for i in bodies(off):
        assert off.materials[off.objects[i].material].emission == (0.0, 0.0, 0.0)
    on = with_lights(room, room.lights, [True] * len(room.lights))
    assert on.lights == room.lights


def test_black_light_can_be_turned_up(room: Scene) -> None:
    dark = with_lights(room, room.lights, [False] * len(room.lights))
    lights = [light.with_emitted((2.0, 2.0, 2.0)) for light in dark.lights]
    lit = with_lights(dark, lights, [True] * len(lights))
    for i in bodies(lit):
        assert lit.materials[lit.objects[i].material].emission == (2.0, 2.0, 2.0)


def test_a_body_of_several_lights_glows_by_their_mean() -> None:
    parts = [
        RectangleLight((i, 0, 0), (w, 0, 0), (0, 1, 0), (1, 2, 4)) for i, w in ((0, 1), (2, 3))
    ]
    box = SceneObject(0, 0, np.eye(4)[None], light=0)
    glowing = Material(emission=(1.0, 2.0, 4.0))
    camera = Camera((0, 0, 5), (0, 0, 0))
    scene = Scene((shapes.quad(),), (glowing,), (box,), camera, tuple(parts))
    for on, left in (((False, True), 0.75), ((True, False), 0.25), ((False, False), 0.0)):
        dimmed = with_lights(scene, parts, on)
        emission = dimmed.materials[dimmed.objects[0].material].emission
        assert emission == pytest.approx((left, 2.0 * left, 4.0 * left)), on
    one_off = scene.with_light(1, parts[1].with_emitted((0.0, 0.0, 0.0)))
    assert one_off.materials[one_off.objects[0].material].emission == pytest.approx(
        (0.25, 0.5, 1.0)
    )


def test_clock_runs_only_where_something_moves() -> None:
    still, moving = Clock.of(False), Clock.of(True)
    for clock in (still, moving):
        clock.advance(0.5)
    assert (still.seconds, moving.seconds) == (0.0, 0.5)
    still.toggle()
    still.step()
    assert still == dataclasses.replace(Clock.of(False))


def test_clock_stops_steps_and_goes_on() -> None:
    clock = Clock.of(True)
    clock.toggle()
    clock.advance(1.0)
    assert clock.seconds == 0.0
    clock.step()
    clock.step()
    assert clock.seconds == pytest.approx(2 * STEP_SECONDS)
    clock.toggle()
    clock.advance(1.0)
    assert clock.seconds == pytest.approx(1.0 + 2 * STEP_SECONDS)
    clock.step()
    assert not clock.is_running


def quarter_turn(about: tuple[float, float, float]) -> np.ndarray:
    """Return a turn by 90 degrees about the vertical through a point."""
    turn = math3d.rotation_euler((0.0, 90.0, 0.0))
    matrix = np.eye(4)
    matrix[:3, :3] = turn[:3, :3]
    return math3d.translation(about) @ matrix @ math3d.translation(np.negative(about))


def test_body_of_a_light_turns_with_it(room: Scene) -> None:
    item = bodies(room)[0]
    index = room.objects[item].light
    assert index is not None
    light = room.lights[index]
    assert isinstance(light, RectangleLight)
    lights = moved_lights(room, room.lights, index, quarter_turn(light.place))
    turned = with_lights(room, lights, [True] * len(lights))
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    matrix = turned.objects[item].world_from_object[0]
    after = lights[index]
    assert isinstance(after, RectangleLight)
    assert np.allclose(after.place, light.place)
    expected = np.add(after.corner, [np.zeros(3), after.edge_u, after.edge_v])
    assert np.allclose(math3d.transform_points(matrix, corners), expected)
    assert not np.allclose(after.edge_u, light.edge_u)


def test_lights_of_one_body_move_and_go_together() -> None:
    glowing = Material(emission=(1.0, 1.0, 1.0))
    box = SceneObject(0, 1, np.eye(4)[None], light=1)
    parts = [RectangleLight((i, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 1)) for i in range(2)]
    lamp = PointLight((0.0, 5.0, 0.0), (1.0, 1.0, 1.0))
    scene = Scene(
        (shapes.quad(),),
        (Material(), glowing),
        (SceneObject(0, 0, np.eye(4)[None]), box),
        Camera((0, 0, 5), (0, 0, 0)),
        (lamp, *parts, lamp),
    )
    moved = moved_lights(scene, scene.lights, 2, math3d.translation((0.0, 0.0, 3.0)))
    assert [light.place for light in moved] == [(0, 5, 0), (0.5, 0.5, 3), (1.5, 0.5, 3), (0, 5, 0)]
    left, gone = without_light(scene, 2)
    assert gone == range(1, 3)
    assert left.lights == (lamp, lamp)
    assert left.objects == scene.objects[:1]
    # A body whose light comes later keeps it.
    earlier, _ = without_light(scene, 0)
    assert [item.light for item in earlier.objects] == [None, 0]


@pytest.mark.parametrize("kind", KINDS.values())
def test_a_new_light_shines_where_the_camera_looks(room: Scene, kind: type[Light]) -> None:
    camera = dataclasses.replace(room.camera, exposure=1.0)
    light = new_light(kind, camera, 2.0)
    ahead = math3d.normalized(np.subtract(camera.target, camera.position))
    point = np.add(camera.position, 4.0 * ahead)
    # As far away as the light is from the camera.
    (irradiance,) = light.irradiance_at(point[None], -ahead[None])
    assert irradiance == pytest.approx(math.pi / 2.0, rel=0.05)
    lit = with_added_light(room, light)
    assert lit.lights[-1] is light
    has_body = kind is RectangleLight
    assert [item.light for item in lit.objects[len(room.objects) :]] == [2] * has_body
