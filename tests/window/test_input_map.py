"""Events in, controls and commands out."""

from __future__ import annotations

import glfw
import pytest

from ssdo_gl.window.camera.controls import Controls
from ssdo_gl.window.input_map import (
    BINDINGS,
    HELD_MOVES,
    HELD_TURNS,
    RADIANS_PER_PX,
    TURN_RATE,
    Action,
    Command,
    InputMap,
    combined,
    gamepad_controls,
    help_rows,
)

NEUTRAL_AXES = (0.0, 0.0, 0.0, 0.0, -1.0, -1.0)
NO_BUTTONS = (0,) * 15


def test_nothing_happens_without_events() -> None:
    assert InputMap().take() == Controls()
    assert Controls().is_idle


def test_held_keys_move_until_let_go() -> None:
    input_map = InputMap()
    input_map.key(glfw.KEY_W, glfw.PRESS)
    input_map.key(glfw.KEY_D, glfw.PRESS)
    input_map.key(glfw.KEY_LEFT_SHIFT, glfw.PRESS, glfw.MOD_SHIFT)
    assert input_map.is_holding
    assert input_map.take() == Controls(move=(1.0, 0.0, 1.0), fast=True)
    input_map.key(glfw.KEY_W, glfw.RELEASE)
    input_map.key(glfw.KEY_LEFT_SHIFT, glfw.RELEASE)
    assert input_map.take() == Controls(move=(1.0, 0.0, 0.0))


def test_opposite_keys_cancel() -> None:
    input_map = InputMap()
    for key in (glfw.KEY_Q, glfw.KEY_E, glfw.KEY_LEFT, glfw.KEY_RIGHT):
        input_map.key(key, glfw.PRESS)
    assert input_map.take().is_idle


def test_tap_between_two_frames_counts_for_one() -> None:
    input_map = InputMap()
    input_map.key(glfw.KEY_W, glfw.PRESS)
    input_map.key(glfw.KEY_W, glfw.RELEASE)
    assert input_map.is_holding
    assert input_map.take().move == (0.0, 0.0, 1.0)
    assert input_map.take().is_idle


def test_arrow_keys_turn_at_a_rate() -> None:
    input_map = InputMap()
    input_map.key(glfw.KEY_LEFT, glfw.PRESS)
    input_map.key(glfw.KEY_UP, glfw.PRESS)
    assert input_map.take().turn_rate == (TURN_RATE, TURN_RATE)


def test_chords_do_not_move() -> None:
    input_map = InputMap()
    input_map.key(glfw.KEY_LEFT_CONTROL, glfw.PRESS, glfw.MOD_CONTROL)
    assert input_map.key(glfw.KEY_Q, glfw.PRESS, glfw.MOD_CONTROL) == Action(Command.QUIT)
    assert input_map.take().is_idle


@pytest.mark.parametrize(
    ("key", "mods", "action"),
    [
        (glfw.KEY_TAB, 0, Action(Command.TOGGLE_PANEL)),
        (glfw.KEY_1, 0, Action(Command.VIEW, 1)),
        (glfw.KEY_0, 0, Action(Command.VIEW, 10)),
        (glfw.KEY_3, glfw.MOD_CONTROL, Action(Command.STORE, 3)),
        (glfw.KEY_3, glfw.MOD_ALT, Action(Command.RECALL, 3)),
        (glfw.KEY_T, 0, Action(Command.NEXT_METHOD)),
        (glfw.KEY_T, glfw.MOD_SHIFT, Action(Command.PREVIOUS_METHOD)),
        # Caps lock on, and shift held for speed: neither changes what a key means.
        (glfw.KEY_V, glfw.MOD_CAPS_LOCK, Action(Command.SPLIT)),
        (glfw.KEY_HOME, glfw.MOD_SHIFT, Action(Command.HOME)),
        (glfw.KEY_R, glfw.MOD_CONTROL, None),
        (glfw.KEY_W, 0, None),
    ],
)
def test_keys_ask_for_commands_once(key: int, mods: int, action: Action | None) -> None:
    input_map = InputMap()
    assert input_map.key(key, glfw.PRESS, mods) == action
    assert input_map.key(key, glfw.REPEAT, mods) is None
    assert input_map.key(key, glfw.RELEASE, mods) is None


def test_holding_the_step_key_goes_on_stepping() -> None:
    assert InputMap().key(glfw.KEY_PERIOD, glfw.REPEAT) == Action(Command.STEP)


def test_mouse_turns_only_while_looking() -> None:
    input_map = InputMap()
    input_map.cursor(100.0, 100.0)
    assert input_map.take().is_idle
    input_map.button(glfw.MOUSE_BUTTON_RIGHT, glfw.PRESS)
    input_map.cursor(110.0, 96.0)
    input_map.cursor(120.0, 90.0)
    assert input_map.is_looking
    # To the right on the screen is to the right (negative) in the camera, up is up.
    assert input_map.take().turn == pytest.approx((-20.0 * RADIANS_PER_PX, 10.0 * RADIANS_PER_PX))
    input_map.button(glfw.MOUSE_BUTTON_RIGHT, glfw.RELEASE)
    input_map.cursor(200.0, 200.0)
    assert input_map.take().is_idle


def test_capture_looks_without_a_button_until_escape() -> None:
    input_map = InputMap()
    input_map.key(glfw.KEY_M, glfw.PRESS)
    input_map.cursor(4.0, 0.0)
    assert input_map.is_looking
    assert input_map.take().turn[0] == pytest.approx(-4.0 * RADIANS_PER_PX)
    input_map.key(glfw.KEY_ESCAPE, glfw.PRESS)
    assert not input_map.is_looking


def test_jump_of_the_cursor_is_no_movement() -> None:
    input_map = InputMap()
    input_map.button(glfw.MOUSE_BUTTON_RIGHT, glfw.PRESS)
    input_map.cursor_jumped(500.0, 500.0)
    input_map.cursor(501.0, 500.0)
    assert input_map.take().turn[0] == pytest.approx(-RADIANS_PER_PX)


def test_middle_button_orbits_and_the_wheel_then_dollies() -> None:
    input_map = InputMap()
    assert input_map.button(glfw.MOUSE_BUTTON_MIDDLE, glfw.PRESS) == Action(Command.ORBIT_START)
    input_map.cursor(10.0, 0.0)
    input_map.scroll(2.0)
    controls = input_map.take()
    assert controls.orbit[0] == pytest.approx(-10.0 * RADIANS_PER_PX)
    assert (controls.dolly, controls.speed, controls.turn) == (2.0, 0.0, (0.0, 0.0))
    input_map.button(glfw.MOUSE_BUTTON_MIDDLE, glfw.RELEASE)
    input_map.scroll(-1.0)
    assert input_map.take().speed == -1.0


def test_losing_the_focus_lets_go_of_everything() -> None:
    input_map = InputMap()
    input_map.key(glfw.KEY_W, glfw.PRESS)
    input_map.button(glfw.MOUSE_BUTTON_RIGHT, glfw.PRESS)
    input_map.cursor(30.0, 30.0)
    input_map.scroll(1.0)
    input_map.focus_lost()
    assert input_map.take() == Controls()
    assert not input_map.is_looking


def test_gamepad_at_rest_does_nothing() -> None:
    drifting = (0.1, -0.12, 0.14, 0.05, -0.95, -1.0)
    assert gamepad_controls(drifting, NO_BUTTONS).is_idle


def test_gamepad_moves_looks_and_lifts() -> None:
    controls = gamepad_controls((1.0, -1.0, 1.0, -1.0, -1.0, 1.0), NO_BUTTONS)
    assert controls.move == pytest.approx((1.0, 1.0, 1.0))
    assert controls.turn_rate == pytest.approx((-TURN_RATE, TURN_RATE))
    buttons = list(NO_BUTTONS)
    buttons[glfw.GAMEPAD_BUTTON_LEFT_BUMPER] = 1
    assert gamepad_controls(NEUTRAL_AXES, buttons).fast


def test_gamepad_response_is_continuous_at_the_dead_zone() -> None:
    inside = gamepad_controls((0.1500001, 0.0, 0.0, 0.0, -1.0, -1.0), NO_BUTTONS)
    assert 0.0 < inside.move[0] < 1e-6


def test_two_devices_add_up() -> None:
    both = combined(Controls(move=(1.0, 0.0, 0.0), speed=1.0), Controls(move=(0.0, 0.0, 0.5)))
    assert both == Controls(move=(1.0, 0.0, 0.5), speed=1.0)


def test_no_key_is_bound_twice_and_the_help_names_every_command() -> None:
    keys = [(item.key, item.mods) for item in BINDINGS]
    assert len(set(keys)) == len(keys)
    assert not {key for key, mods in keys if mods == 0} & {*HELD_MOVES, *HELD_TURNS}
    shown = {meaning for _, meaning in help_rows()}
    for command in Command:
        assert command == Command.ORBIT_START or command.value in shown
