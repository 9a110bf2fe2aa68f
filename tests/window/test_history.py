"""Undo and redo, without a window."""

from __future__ import annotations

import dataclasses

from window.driven_viewer import Clock

from ssdo_gl.scene.environment import Daylight, sky
from ssdo_gl.scene.environment.environment_kinds import ConstantEnvironment
from ssdo_gl.scene.light_edits import without_light
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.material_edits import edited_material, with_edited
from ssdo_gl.settings import Settings
from ssdo_gl.window.history import ONE_WALK_SECONDS, Edited, History

ROOM = load_scene("cornell_meso")
START = Edited(Settings(), ROOM.lights, (True,) * len(ROOM.lights), ROOM, ROOM.camera)


def samples(count: int, edited: Edited = START) -> Edited:
    return dataclasses.replace(edited, settings=Settings(samples=count))


def at(x: float) -> Edited:
    camera = dataclasses.replace(START.camera, position=(x, 0.0, 3.0))
    return dataclasses.replace(START, camera=camera)


def test_steps_go_back_and_forth_in_order() -> None:
    history = History(START)
    for count in (8, 16, 64):
        history.note(samples(count))
    assert [history.undo() for _ in range(4)] == [samples(16), samples(8), START, None]
    assert [history.redo() for _ in range(4)] == [samples(8), samples(16), samples(64), None]


def test_what_is_the_same_is_no_step() -> None:
    history = History(START)
    history.note(samples(Settings().samples))
    assert not history.can_undo


def test_a_new_step_forgets_what_was_undone() -> None:
    history = History(START)
    history.note(samples(8))
    history.undo()
    history.note(samples(16))
    assert not history.can_redo
    assert history.undo() == START


def test_a_walk_is_one_step_and_an_edit_is_none_of_it() -> None:
    clock = Clock()
    history = History(START, clock)
    for x in (1.0, 2.0, 3.0):
        clock.seconds += 0.5 * ONE_WALK_SECONDS
        history.note(at(x))
    history.note(samples(8, at(3.0)))
    clock.seconds += 2.0 * ONE_WALK_SECONDS
    history.note(samples(8, at(4.0)))
    assert history.undo() == samples(8, at(3.0))
    assert history.undo() == at(3.0)
    assert history.undo() == START


def test_differences_are_named() -> None:
    off = dataclasses.replace(START, lights_on=(False,) * len(START.lights))
    assert off.difference(START) == "lights"
    assert samples(8, at(1.0)).difference(START) == "settings, camera"
    assert START.difference(START) == ""
    fewer, _ = without_light(ROOM, 0)
    assert dataclasses.replace(START, original=fewer).difference(START) == "lights"
    painted = with_edited(ROOM, 0, edited_material(ROOM.materials[0], {"roughness": 0.5}))
    assert dataclasses.replace(START, original=painted).difference(START) == "materials"
    dark = dataclasses.replace(ROOM, environment=ConstantEnvironment((1.0, 1.0, 1.0)))
    assert dataclasses.replace(START, original=dark).difference(START) == "environment"


def test_the_sun_goes_with_its_sky_there_and_back(gl, make_viewer) -> None:
    viewer = make_viewer("corner", light="sky:9")
    viewer.change_environment(sky(Daylight(17.0)))
    (sun,) = viewer.lights
    assert sun.direction == Daylight(17.0).sun().direction
    viewer.change_environment(viewer.loaded.environment)
    assert tuple(viewer.lights) == viewer.loaded.lights
    assert not viewer.is_edited
