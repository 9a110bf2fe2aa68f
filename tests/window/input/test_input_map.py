"""Events in, controls and commands out."""

from __future__ import annotations

import math

import glfw
import pytest

from ssdo_gl.window.camera.controls import Controls
from ssdo_gl.window.input.bindings import (
    BINDINGS,
    HELD_MOVES,
    HELD_TURNS,
    Action,
    Command,
    help_groups,
)
from ssdo_gl.window.input.input_map import (
    DOUBLE_CLICK_SECONDS,
    DRAG_PX,
    ORBIT_RADIANS_PER_PX,
    RADIANS_PER_PX,
    TAP_SECONDS,
    TURN_RAMP_SECONDS,
    TURN_RATE,
    InputMap,
    combined,
    gamepad_controls,
)

NEUTRAL_AXES = (0.0, 0.0, 0.0, 0.0, -1.0, -1.0)
NO_BUTTONS = (0,) * 15


class Hand:
    """An input map, a clock, and frames that look at it."""

    def __init__(self, frame_s: float = 1.0 / 60.0) -> None:
        self.now = 100.0
        self.frame_s = frame_s
        self.map = InputMap(lambda: self.now)

    def frame(self) -> Controls:
        """Let a frame pass and take what was asked for in it."""
        since, self.now = self.now, self.now + self.frame_s
        return self.map.take(since, self.now)

    def hold(self, key: int, seconds: float, frames_s: float) -> float:
        """Return the angle that a held key turns, in frames of `frames_s` seconds."""
        end, self.frame_s = self.now + seconds, frames_s
        self.map.key(key, glfw.PRESS)
        turned = 0.0
        while self.map.is_holding:
            since = self.now
            release = since < end <= since + frames_s
            self.now = end if release else since + frames_s
            if release:
                self.map.key(key, glfw.RELEASE)
            self.now = since + frames_s
            controls = self.map.take(since, self.now)
            turned += controls.turn[0] + controls.turn_rate[0] * frames_s
        return turned


def taken(input_map: InputMap) -> Controls:
    now = input_map._clock()
    return input_map.take(now - 1e-3, now)


@pytest.mark.parametrize("frame_s", [1.0 / 240.0, 1.0 / 60.0, 0.1, 0.25])
def test_a_tap_turns_by_a_degree_however_long_frames_take(frame_s: float) -> None:
    turned = Hand().hold(glfw.KEY_LEFT, 0.08, frame_s)
    assert turned == pytest.approx(TURN_RATE * 0.08**2 / (2.0 * TURN_RAMP_SECONDS))
    assert 0.5 < math.degrees(turned) < 1.5


def test_the_first_picture_of_a_tap_shows_all_of_its_turn() -> None:
    hand = Hand(0.001)
    for key in (glfw.KEY_LEFT, glfw.KEY_UP, glfw.KEY_LEFT):
        hand.map.key(key, glfw.PRESS)
        hand.map.key(key, glfw.RELEASE)
    controls = hand.frame()
    tap = TURN_RATE * 0.08**2 / (2.0 * TURN_RAMP_SECONDS)
    assert controls.turn == pytest.approx((2.0 * tap, tap))
    # In the time of the tap, nothing more.
    while hand.map.is_holding:
        assert hand.frame().is_idle
    assert hand.frame().is_idle


@pytest.mark.parametrize("frame_s", [1.0 / 60.0, 0.25])
def test_a_held_key_comes_to_its_full_rate(frame_s: float) -> None:
    turned = Hand().hold(glfw.KEY_LEFT, 2.0, frame_s)
    assert turned == pytest.approx(TURN_RATE * (2.0 - 0.5 * TURN_RAMP_SECONDS))


def test_a_key_moves_for_the_time_that_it_was_held() -> None:
    hand = Hand(0.5)
    hand.map.key(glfw.KEY_W, glfw.PRESS)
    hand.now += 0.1
    hand.map.key(glfw.KEY_W, glfw.RELEASE)
    hand.now -= 0.1
    assert hand.frame().move == pytest.approx((0.0, 0.0, 0.2))
    assert hand.frame().is_idle


def test_nothing_happens_without_events() -> None:
    assert taken(InputMap()) == Controls()
    assert Controls().is_idle


def test_held_keys_move_until_let_go() -> None:
    hand = Hand()
    hand.map.key(glfw.KEY_W, glfw.PRESS)
    hand.map.key(glfw.KEY_D, glfw.PRESS)
    hand.map.key(glfw.KEY_LEFT_SHIFT, glfw.PRESS, glfw.MOD_SHIFT)
    assert hand.map.is_holding
    for _ in range(20):
        assert hand.frame() == Controls(move=(1.0, 0.0, 1.0), fast=True)
    hand.map.key(glfw.KEY_W, glfw.RELEASE)
    hand.map.key(glfw.KEY_LEFT_SHIFT, glfw.RELEASE)
    assert hand.frame() == Controls(move=(1.0, 0.0, 0.0))


def test_opposite_keys_cancel() -> None:
    hand = Hand()
    for key in (glfw.KEY_Q, glfw.KEY_E, glfw.KEY_LEFT, glfw.KEY_RIGHT):
        hand.map.key(key, glfw.PRESS)
    assert hand.frame().is_idle


def test_tap_between_two_frames_lasts_for_a_moment() -> None:
    hand = Hand()
    hand.map.key(glfw.KEY_W, glfw.PRESS)
    hand.map.key(glfw.KEY_W, glfw.RELEASE)
    moved = 0.0
    while hand.map.is_holding:
        moved += hand.frame().move[2] * hand.frame_s
    assert moved == pytest.approx(TAP_SECONDS)
    assert hand.frame().is_idle


def test_chords_do_not_move() -> None:
    input_map = InputMap()
    input_map.key(glfw.KEY_LEFT_CONTROL, glfw.PRESS, glfw.MOD_CONTROL)
    assert input_map.key(glfw.KEY_Q, glfw.PRESS, glfw.MOD_CONTROL) == Action(Command.QUIT)
    assert taken(input_map).is_idle


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
        (glfw.KEY_R, glfw.MOD_CONTROL, Action(Command.RESET)),
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
    assert taken(input_map).is_idle
    input_map.button(glfw.MOUSE_BUTTON_RIGHT, glfw.PRESS)
    input_map.cursor(110.0, 96.0)
    input_map.cursor(120.0, 90.0)
    assert input_map.is_looking
    # To the right on the screen is to the right (negative) in the camera, up is up.
    assert taken(input_map).turn == pytest.approx((-20.0 * RADIANS_PER_PX, 10.0 * RADIANS_PER_PX))
    input_map.button(glfw.MOUSE_BUTTON_RIGHT, glfw.RELEASE)
    input_map.cursor(200.0, 200.0)
    assert taken(input_map).is_idle


def test_capture_looks_without_a_button_until_escape() -> None:
    input_map = InputMap()
    input_map.key(glfw.KEY_M, glfw.PRESS)
    input_map.cursor(4.0, 0.0)
    assert input_map.is_looking
    assert taken(input_map).turn[0] == pytest.approx(-4.0 * RADIANS_PER_PX)
    input_map.key(glfw.KEY_ESCAPE, glfw.PRESS)
    assert not input_map.is_looking


def test_jump_of_the_cursor_is_no_movement() -> None:
    input_map = InputMap()
    input_map.button(glfw.MOUSE_BUTTON_RIGHT, glfw.PRESS)
    input_map.cursor_jumped(500.0, 500.0)
    input_map.cursor(501.0, 500.0)
    assert taken(input_map).turn[0] == pytest.approx(-RADIANS_PER_PX)


def drag(input_map: InputMap, button: int) -> Controls:
    input_map.cursor_jumped(100.0, 100.0)
    assert input_map.button(button, glfw.PRESS) == Action(Command.PIVOT)
    input_map.cursor(100.0 + 0.5 * DRAG_PX, 100.0)
    assert taken(input_map).is_idle, "a hand that clicks is no drag"
    input_map.cursor(120.0, 110.0)
    controls = input_map.take(0.0, 1.0, height=200.0)
    input_map.button(button, glfw.RELEASE)
    input_map.cursor(300.0, 100.0)
    assert taken(input_map).is_idle
    return controls


def test_left_drag_orbits_and_middle_drag_slides() -> None:
    orbit = (-20.0 * ORBIT_RADIANS_PER_PX, -10.0 * ORBIT_RADIANS_PER_PX)
    assert drag(InputMap(), glfw.MOUSE_BUTTON_LEFT).orbit == pytest.approx(orbit)
    assert drag(InputMap(), glfw.MOUSE_BUTTON_MIDDLE).slide == pytest.approx((0.1, -0.05))


def test_wheel_comes_closer_and_while_flying_sets_the_speed() -> None:
    hand = Hand()
    assert hand.map.scroll(2.0) == Action(Command.ZOOM)
    controls = hand.frame()
    assert (controls.dolly, controls.speed) == (2.0, 0.0)
    hand.map.button(glfw.MOUSE_BUTTON_RIGHT, glfw.PRESS)
    assert hand.map.scroll(-1.0) is None
    assert hand.frame().speed == -1.0
    hand.map.button(glfw.MOUSE_BUTTON_RIGHT, glfw.RELEASE)
    hand.map.key(glfw.KEY_W, glfw.PRESS)
    assert hand.map.scroll(1.0) is None
    assert hand.frame().speed == 1.0


def test_two_clicks_focus_only_when_near_and_soon() -> None:
    def clicks(pause: float, way: float) -> list[Action | None]:
        hand = Hand()
        asked = []
        for _ in range(2):
            asked.append(hand.map.button(glfw.MOUSE_BUTTON_LEFT, glfw.PRESS))
            hand.map.button(glfw.MOUSE_BUTTON_LEFT, glfw.RELEASE)
            hand.now += pause
            hand.map.cursor(way, 0.0)
        return asked

    pivot, focus = Action(Command.PIVOT), Action(Command.FOCUS)
    assert clicks(0.5 * DOUBLE_CLICK_SECONDS, 1.0) == [pivot, focus]
    assert clicks(2.0 * DOUBLE_CLICK_SECONDS, 1.0) == [pivot, pivot]
    assert clicks(0.5 * DOUBLE_CLICK_SECONDS, 2.0 * DRAG_PX) == [pivot, pivot]


def test_losing_the_focus_lets_go_of_everything() -> None:
    input_map = InputMap()
    input_map.key(glfw.KEY_W, glfw.PRESS)
    input_map.button(glfw.MOUSE_BUTTON_RIGHT, glfw.PRESS)
    input_map.cursor(30.0, 30.0)
    input_map.scroll(1.0)
    input_map.focus_lost()
    assert taken(input_map) == Controls()
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
    shown = {meaning for rows in help_groups().values() for _, meaning in rows}
    for command in Command:
        assert command in (Command.PIVOT, Command.ZOOM) or command.value in shown


def test_an_event_that_had_to_wait_counts_from_when_it_came() -> None:
    hand = Hand()
    came, hand.now = hand.now, hand.now + 0.5
    hand.map.as_of(came, lambda: hand.map.key(glfw.KEY_W, glfw.PRESS) and None)
    hand.map.as_of(came + 0.2, lambda: hand.map.key(glfw.KEY_W, glfw.RELEASE) and None)
    assert hand.map.take(came, hand.now).move[2] == pytest.approx(0.2 / 0.5)
