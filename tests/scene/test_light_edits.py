"""Lights changed in the window, and the bodies that stand for them in the picture."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ssdo_gl.scene.light_edits import with_lights
from ssdo_gl.scene.load import load_scene
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
