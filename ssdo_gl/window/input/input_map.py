"""From events of keys and mouse, and the state of a gamepad, to controls and commands.

Takes GLFW's numbers but calls nothing of GLFW, so that a test can press keys. How far a key
moves follows from when it went down and up, never from how long a frame took.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import add
from typing import Any

import glfw

from ssdo_gl.window.camera import Controls
from ssdo_gl.window.input.bindings import (
    CHORD,
    FAST_KEYS,
    HELD_MOVES,
    HELD_TURNS,
    Action,
    Command,
    binding_of,
)

# 400 px of mouse turn the view by about 60 degrees: a flick of the wrist.
RADIANS_PER_PX = 0.0025
# Half a turn around a thing in the height of a small window.
ORBIT_RADIANS_PER_PX = 0.006
# Radians per second of an arrow key that is held, or a stick: around in 4 s.
TURN_RATE = 1.6
# It comes to that rate in this time: who taps wants a degree, who holds wants to turn.
TURN_RAMP_SECONDS = 0.3
# A tap lasts at least this long, however soon the release was heard of. What it turns by in
# all is turned at once: the first picture shows it, and nobody has to wait for more of it.
TAP_SECONDS = 0.08
# A hand that clicks moves the mouse by less.
DRAG_PX = 3.0
DOUBLE_CLICK_SECONDS = 0.4
# A stick at rest reports up to a tenth of its way; a trigger is quieter.
STICK_DEAD_ZONE = 0.15
TRIGGER_DEAD_ZONE = 0.05


@dataclass
class _Hold:
    """A key that is held: since when, and until when once it was let go."""

    start: float
    end: float = math.inf

    def share(self, since: float, now: float) -> float:
        """Return for which part of a time it was held."""
        held = min(self.end, now) - max(self.start, since)
        return min(1.0, max(0.0, held / (now - since))) if now > since else 1.0

    def ramped(self, since: float, now: float) -> float:
        """Return the mean, after a tap's time, of a strength that grows to 1."""
        if now <= since:
            return 0.0
        ages = (max(min(t, self.end) - self.start, TAP_SECONDS) for t in (since, now))
        before, after = (_ramp_integral(age) for age in ages)
        return (after - before) / (now - since)


class InputMap:
    """Collects events between two frames.

    Events of what is pressed come only while no text field or widget wants them;
    releases always come, so that nothing is held for ever.

    Parameters
    ----------
    clock : callable
        Returns seconds: when an event is.

    Attributes
    ----------
    captured : bool
        Whether the mouse looks around without a button.
    cursor_px : (float, float)
        Last position, window coordinates, origin at the top left.
    """

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self.captured = False
        self.cursor_px = (0.0, 0.0)
        self._clock = clock
        self._keys: dict[int, _Hold] = {}
        self._buttons: set[int] = set()
        self._pressed_px = (0.0, 0.0)
        self._clicked_at = -math.inf
        self._is_drag = False
        self._came_at: float | None = None
        self._forget_mouse()

    def _forget_mouse(self) -> None:
        self._looked, self._orbited, self._slid = ([0.0, 0.0] for _ in range(3))
        self._tapped = [0.0, 0.0]
        self._notches = self._speed_notches = 0.0

    @property
    def now(self) -> float:
        """When the event in hand is: of one that had to wait, when it came."""
        return self._clock() if self._came_at is None else self._came_at

    def as_of(self, when: float, handle: Callable[[], None]) -> None:
        """Handle an event that came at another time, by the clock of events."""
        self._came_at = when
        try:
            handle()
        finally:
            self._came_at = None

    @property
    def is_looking(self) -> bool:
        """Whether mouse movement turns the camera, so that the cursor should hide."""
        return self.captured or glfw.MOUSE_BUTTON_RIGHT in self._buttons

    @property
    def is_dragging(self) -> bool:
        """Whether mouse movement orbits or slides."""
        return bool(self._buttons) and not self.is_looking

    @property
    def is_holding(self) -> bool:
        """Whether a key is held that moves or turns the camera."""
        now = self.now
        return any(
            hold.end > now
            for key, hold in self._keys.items()
            if key in HELD_MOVES or key in HELD_TURNS
        )

    def key(self, key: int, action: int, mods: int = 0) -> Action | None:
        """Take a key event; return what it asks for once, if anything."""
        if action == glfw.RELEASE:
            if key in self._keys:
                hold = self._keys[key]
                hold.end = max(self.now, hold.start + TAP_SECONDS)
            return None
        if action == glfw.PRESS and not mods & CHORD:
            self._keys[key] = _Hold(self.now)
            tap = TURN_RATE * _ramp_integral(TAP_SECONDS)
            self._tapped = _summed([self._tapped, _scaled(HELD_TURNS.get(key, (0, 0)), tap)], 2)
        binding = binding_of(key, mods)
        # Holding a key repeats steps, never toggles.
        if binding is None or (action == glfw.REPEAT and binding.command != Command.STEP):
            return None
        if binding.command == Command.CAPTURE:
            self.captured = not self.captured
        elif binding.command == Command.RELEASE:
            self.captured = False
        return Action(binding.command, binding.number)

    def button(self, button: int, action: int) -> Action | None:
        """Take a mouse button event: a drag takes its pivot, two clicks focus."""
        if action == glfw.RELEASE:
            self._buttons.discard(button)
            return None
        self._buttons.add(button)
        now, before = self.now, self._clicked_at
        near = math.dist(self._pressed_px, self.cursor_px) < DRAG_PX
        self._pressed_px, self._is_drag = self.cursor_px, False
        if self.is_looking or button not in (glfw.MOUSE_BUTTON_LEFT, glfw.MOUSE_BUTTON_MIDDLE):
            return None
        if button == glfw.MOUSE_BUTTON_LEFT:
            is_double = near and now - before < DOUBLE_CLICK_SECONDS
            self._clicked_at = -math.inf if is_double else now
            if is_double:
                return Action(Command.FOCUS)
        return Action(Command.PIVOT)

    def cursor(self, x: float, y: float) -> None:
        """Take the cursor's position, window coordinates."""
        dx, dy = x - self.cursor_px[0], y - self.cursor_px[1]
        self.cursor_px = (x, y)
        if self.is_looking:
            moved = self._looked
        elif self.is_dragging:
            if not self._is_drag:
                # From where the button went down, so that nothing of the way is lost.
                dx, dy = x - self._pressed_px[0], y - self._pressed_px[1]
                self._is_drag = math.hypot(dx, dy) >= DRAG_PX
                if not self._is_drag:
                    return
            slides = glfw.MOUSE_BUTTON_MIDDLE in self._buttons
            moved = self._slid if slides else self._orbited
        else:
            return
        moved[0] += dx
        moved[1] += dy

    def cursor_jumped(self, x: float, y: float) -> None:
        """Note a position that no mouse movement has led to (capture, another window)."""
        self.cursor_px = (x, y)

    def scroll(self, notches: float) -> Action | None:
        """Take the wheel; positive is away from the user."""
        if self.is_looking or self.is_holding:
            self._speed_notches += notches
            return None
        self._notches += notches
        return Action(Command.ZOOM)

    def focus_lost(self) -> None:
        """Let go of everything: releases will go to another window."""
        self._keys.clear()
        self._buttons.clear()
        self.captured = False
        self._forget_mouse()

    def take(self, since: float, now: float, height: float = 1.0) -> Controls:
        """Return the controls between two times, and begin anew.

        Parameters
        ----------
        since, now : float
            By the clock of the events.
        height : float
            Of the window, in its coordinates.
        """
        keys = self._keys
        shares = {key: hold.share(since, now) for key, hold in keys.items()}
        strengths = {key: hold.ramped(since, now) for key, hold in keys.items()}
        move = _summed([_scaled(HELD_MOVES[k], shares[k]) for k in keys if k in HELD_MOVES], 3)
        turn = _summed([_scaled(HELD_TURNS[k], strengths[k]) for k in keys if k in HELD_TURNS], 2)
        fast = any(shares.get(key, 0.0) > 0.0 for key in FAST_KEYS)
        self._keys = {key: hold for key, hold in keys.items() if hold.end > now}
        # Right and down are positive on a screen; left and up are in the camera.
        looked = [-RADIANS_PER_PX * way for way in self._looked]
        orbited = [-ORBIT_RADIANS_PER_PX * way for way in self._orbited]
        slid = self._slid[0] / max(1.0, height), -self._slid[1] / max(1.0, height)
        controls = Controls(
            move=(move[0], move[1], move[2]),
            turn=(looked[0] + self._tapped[0], looked[1] + self._tapped[1]),
            turn_rate=(TURN_RATE * turn[0], TURN_RATE * turn[1]),
            orbit=(orbited[0], orbited[1]),
            slide=slid,
            dolly=self._notches,
            speed=self._speed_notches,
            fast=fast,
        )
        self._forget_mouse()
        return controls


def combined(a: Controls, b: Controls) -> Controls:
    """Return what two devices ask for together; the camera limits the sum."""
    sums: dict[str, Any] = {
        name: tuple(map(add, getattr(a, name), getattr(b, name)))
        for name in ("move", "turn", "turn_rate", "orbit", "slide")
    }
    return Controls(**sums, dolly=a.dolly + b.dolly, speed=a.speed + b.speed, fast=a.fast or b.fast)


def _ramp_integral(age: float) -> float:
    """Return the integral from 0 to `age` of a strength that grows to 1 and stays."""
    if age < TURN_RAMP_SECONDS:
        return 0.5 * age * age / TURN_RAMP_SECONDS
    return age - 0.5 * TURN_RAMP_SECONDS


def _scaled(values: Sequence[float], factor: float) -> list[float]:
    return [factor * value for value in values]


def _summed(parts: Sequence[Sequence[float]], count: int) -> list[float]:
    return [sum(part[i] for part in parts) for i in range(count)]


def gamepad_controls(axes: Sequence[float], buttons: Sequence[int]) -> Controls:
    """Return the controls of a gamepad in GLFW's standard layout.

    Left stick: move; right stick: look; triggers: down and up; a shoulder button: fast.
    """
    right, back, look_right, look_down = (_stick(a) for a in axes[:4])
    down, up = (_past(0.5 + 0.5 * a, TRIGGER_DEAD_ZONE) for a in axes[4:6])
    return Controls(
        move=(right, up - down, -back),
        turn_rate=(-TURN_RATE * look_right, -TURN_RATE * look_down),
        fast=bool(
            buttons[glfw.GAMEPAD_BUTTON_LEFT_BUMPER] or buttons[glfw.GAMEPAD_BUTTON_RIGHT_BUMPER]
        ),
    )


def _past(value: float, dead_zone: float) -> float:
    """Return 0 inside the dead zone and what is beyond it stretched to 0..1."""
    return max(0.0, (value - dead_zone) / (1.0 - dead_zone))


def _stick(value: float) -> float:
    """Return a stick's axis with its dead zone removed, squared for a fine touch."""
    strength = _past(abs(value), STICK_DEAD_ZONE) ** 2
    return strength if value >= 0.0 else -strength
