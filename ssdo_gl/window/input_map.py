"""From keys, mouse and gamepad to controls and commands: the one table of bindings.

Takes GLFW's numbers but calls nothing of GLFW, so that a test can press keys.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import glfw

from ssdo_gl.math3d import Vector
from ssdo_gl.window.camera import Controls

# 400 px of mouse turn the view by about 60 degrees: a flick of the wrist.
RADIANS_PER_PX = 0.0025
# Radians per second of the arrow keys and of a stick pushed to its end: around in 4 s.
TURN_RATE = 1.6
# A stick at rest reports up to a tenth of its way; a trigger is quieter.
STICK_DEAD_ZONE = 0.15
TRIGGER_DEAD_ZONE = 0.05


class Command(StrEnum):
    """What a key can ask for once; the value is what the help says of it."""

    TOGGLE_PANEL = "show or hide the panel"
    TOGGLE_HELP = "show or hide this list"
    CAPTURE = "look with the mouse, until Esc"
    RELEASE = "let go of the mouse, close the help"
    FOCUS = "turn to the point under the cursor and approach it"
    HOME = "back to where the scene begins"
    COLLIDE = "stop at walls, or not"
    VIEW = "show image 1 to 9, 0 is the tenth"
    NEXT_METHOD = "next method"
    PREVIOUS_METHOD = "previous method"
    SPLIT = "split view between two methods, or back"
    NEXT_OTHER_METHOD = "next method on the right of the divider"
    ERROR = "difference of the two methods in false colour, or back"
    INSPECT = "values under the cursor, or not"
    PAUSE = "stop or go on with the animation"
    STEP = "one step of a stopped animation"
    RELOAD = "compile shaders that have changed"
    SCREENSHOT = "picture and settings to files"
    SAVE_PRESET = "settings to a file for --preset"
    COPY_COMMAND = "copy the command that renders this view"
    STORE = "keep this view as bookmark 1 to 9"
    RECALL = "go to bookmark 1 to 9"
    RECORD = "record a camera path, or end it"
    PLAY = "play the camera path, or stop"
    EXPORT = "export the camera path as a film"
    GOVERNOR = "hold the time budget, or not"
    VSYNC = "wait for the display, or not"
    FULLSCREEN = "fill the screen, or back"
    ORBIT_START = "middle button: turn around the point under the cursor"
    QUIT = "leave"


@dataclass(frozen=True)
class Action:
    """A command and, for numbered ones, which: 1 to 10, else 0."""

    command: Command
    number: int = 0


@dataclass(frozen=True)
class Binding:
    """One key with its modifiers, as the help shows it."""

    label: str
    key: int
    command: Command
    mods: int = 0
    number: int = 0


_DIGITS = (*range(glfw.KEY_1, glfw.KEY_9 + 1), glfw.KEY_0)
BINDINGS: tuple[Binding, ...] = (
    Binding("Tab", glfw.KEY_TAB, Command.TOGGLE_PANEL),
    Binding("F1", glfw.KEY_F1, Command.TOGGLE_HELP),
    Binding("H", glfw.KEY_H, Command.TOGGLE_HELP),
    Binding("M", glfw.KEY_M, Command.CAPTURE),
    Binding("Esc", glfw.KEY_ESCAPE, Command.RELEASE),
    Binding("F", glfw.KEY_F, Command.FOCUS),
    Binding("Home", glfw.KEY_HOME, Command.HOME),
    Binding("B", glfw.KEY_B, Command.COLLIDE),
    *(Binding(str(i % 10), k, Command.VIEW, 0, i) for i, k in enumerate(_DIGITS, 1)),
    Binding("T", glfw.KEY_T, Command.NEXT_METHOD),
    Binding("Shift+T", glfw.KEY_T, Command.PREVIOUS_METHOD, glfw.MOD_SHIFT),
    Binding("V", glfw.KEY_V, Command.SPLIT),
    Binding("Y", glfw.KEY_Y, Command.NEXT_OTHER_METHOD),
    Binding("X", glfw.KEY_X, Command.ERROR),
    Binding("I", glfw.KEY_I, Command.INSPECT),
    Binding("Space", glfw.KEY_SPACE, Command.PAUSE),
    Binding(".", glfw.KEY_PERIOD, Command.STEP),
    Binding("R", glfw.KEY_R, Command.RELOAD),
    Binding("F12", glfw.KEY_F12, Command.SCREENSHOT),
    Binding("Ctrl+S", glfw.KEY_S, Command.SAVE_PRESET, glfw.MOD_CONTROL),
    Binding("C", glfw.KEY_C, Command.COPY_COMMAND),
    Binding("Ctrl+C", glfw.KEY_C, Command.COPY_COMMAND, glfw.MOD_CONTROL),
    *(
        Binding(f"Ctrl+{i}", k, Command.STORE, glfw.MOD_CONTROL, i)
        for i, k in enumerate(_DIGITS[:9], 1)
    ),
    *(
        Binding(f"Alt+{i}", k, Command.RECALL, glfw.MOD_ALT, i)
        for i, k in enumerate(_DIGITS[:9], 1)
    ),
    Binding("L", glfw.KEY_L, Command.RECORD),
    Binding("P", glfw.KEY_P, Command.PLAY),
    Binding("Ctrl+P", glfw.KEY_P, Command.EXPORT, glfw.MOD_CONTROL),
    Binding("G", glfw.KEY_G, Command.GOVERNOR),
    Binding("U", glfw.KEY_U, Command.VSYNC),
    Binding("F11", glfw.KEY_F11, Command.FULLSCREEN),
    Binding("Ctrl+Q", glfw.KEY_Q, Command.QUIT, glfw.MOD_CONTROL),
)
# What moves for as long as it is held: (right, up, forward) and (left, up) turns.
HELD_MOVES: dict[int, Vector] = {
    glfw.KEY_W: (0.0, 0.0, 1.0),
    glfw.KEY_S: (0.0, 0.0, -1.0),
    glfw.KEY_D: (1.0, 0.0, 0.0),
    glfw.KEY_A: (-1.0, 0.0, 0.0),
    glfw.KEY_E: (0.0, 1.0, 0.0),
    glfw.KEY_Q: (0.0, -1.0, 0.0),
}
HELD_TURNS: dict[int, tuple[float, float]] = {
    glfw.KEY_LEFT: (1.0, 0.0),
    glfw.KEY_RIGHT: (-1.0, 0.0),
    glfw.KEY_UP: (0.0, 1.0),
    glfw.KEY_DOWN: (0.0, -1.0),
}
FAST_KEYS = (glfw.KEY_LEFT_SHIFT, glfw.KEY_RIGHT_SHIFT)
HELD_HELP = (
    ("W A S D", "forward, left, back, right"),
    ("E Q", "up, down"),
    ("Shift", "four times as fast"),
    ("wheel", "speed; while orbiting, distance"),
    ("right button", "look around"),
    ("middle button", "turn around the point under the cursor"),
    ("arrow keys", "look around"),
)
_BY_KEY = {(item.key, item.mods): item for item in BINDINGS}
# Caps lock and num lock say nothing about what is meant.
_MEANT = glfw.MOD_SHIFT | glfw.MOD_CONTROL | glfw.MOD_ALT | glfw.MOD_SUPER
_CHORD = glfw.MOD_CONTROL | glfw.MOD_ALT | glfw.MOD_SUPER


class InputMap:
    """Collects events between two frames.

    Events of what is pressed come only while no text field or widget wants them;
    releases always come, so that nothing is held for ever.

    Attributes
    ----------
    captured : bool
        Whether the mouse looks around without a button.
    cursor_px : (float, float)
        Last position, window coordinates, origin at the top left.
    """

    def __init__(self) -> None:
        self.captured = False
        self.cursor_px = (0.0, 0.0)
        self._keys: set[int] = set()
        # Pressed and let go again between two frames: still held for one of them.
        self._tapped: set[int] = set()
        self._buttons: set[int] = set()
        self._moved = [0.0, 0.0]
        self._orbited = [0.0, 0.0]
        self._notches = 0.0

    @property
    def is_looking(self) -> bool:
        """Whether mouse movement turns the camera, so that the cursor should hide."""
        return self.captured or glfw.MOUSE_BUTTON_RIGHT in self._buttons

    @property
    def is_orbiting(self) -> bool:
        """Whether mouse movement turns the camera around the pivot."""
        return glfw.MOUSE_BUTTON_MIDDLE in self._buttons and not self.is_looking

    @property
    def is_dragging(self) -> bool:
        """Whether the left button is held."""
        return glfw.MOUSE_BUTTON_LEFT in self._buttons

    @property
    def is_holding(self) -> bool:
        """Whether a key is held that moves or turns the camera."""
        return any(key in HELD_MOVES or key in HELD_TURNS for key in self._held())

    def key(self, key: int, action: int, mods: int = 0) -> Action | None:
        """Take a key event; return what it asks for once, if anything."""
        if action == glfw.RELEASE:
            self._keys.discard(key)
            return None
        mods &= _MEANT
        if action == glfw.PRESS and not mods & _CHORD:
            self._keys.add(key)
            self._tapped.add(key)
        binding = _BY_KEY.get((key, mods))
        if binding is None and not mods & _CHORD:
            binding = _BY_KEY.get((key, 0))
        # Holding a key repeats steps, never toggles.
        if binding is None or (action == glfw.REPEAT and binding.command != Command.STEP):
            return None
        if binding.command == Command.CAPTURE:
            self.captured = not self.captured
        elif binding.command == Command.RELEASE:
            self.captured = False
        return Action(binding.command, binding.number)

    def button(self, button: int, action: int) -> Action | None:
        """Take a mouse button event; the middle one starts an orbit."""
        if action == glfw.RELEASE:
            self._buttons.discard(button)
            return None
        self._buttons.add(button)
        if button == glfw.MOUSE_BUTTON_MIDDLE and self.is_orbiting:
            return Action(Command.ORBIT_START)
        return None

    def cursor(self, x: float, y: float) -> None:
        """Take the cursor's position, window coordinates."""
        delta = x - self.cursor_px[0], y - self.cursor_px[1]
        self.cursor_px = (x, y)
        moved = self._moved if self.is_looking else self._orbited if self.is_orbiting else None
        if moved is not None:
            moved[0] += delta[0]
            moved[1] += delta[1]

    def cursor_jumped(self, x: float, y: float) -> None:
        """Note a position that no mouse movement has led to (capture, another window)."""
        self.cursor_px = (x, y)

    def scroll(self, notches: float) -> None:
        """Take the wheel; positive is away from the user."""
        self._notches += notches

    def focus_lost(self) -> None:
        """Let go of everything: releases will go to another window."""
        self._keys.clear()
        self._tapped.clear()
        self._buttons.clear()
        self.captured = False
        self._moved, self._orbited, self._notches = [0.0, 0.0], [0.0, 0.0], 0.0

    def take(self, orbiting: bool = False) -> Controls:
        """Return the controls since the last call, and begin anew.

        Parameters
        ----------
        orbiting : bool
            The camera stands in relation to a pivot: the wheel changes its distance.
        """
        held = self._held()
        self._tapped.clear()
        move = _summed([HELD_MOVES[k] for k in held if k in HELD_MOVES], 3)
        turn = _summed([HELD_TURNS[k] for k in held if k in HELD_TURNS], 2)
        # Right and down are positive on a screen; left and up are in the camera.
        looked, orbited = (
            (-RADIANS_PER_PX * m[0], -RADIANS_PER_PX * m[1]) for m in (self._moved, self._orbited)
        )
        notches = self._notches
        self._moved, self._orbited, self._notches = [0.0, 0.0], [0.0, 0.0], 0.0
        dollies = orbiting or self.is_orbiting
        return Controls(
            move=(move[0], move[1], move[2]),
            turn=looked,
            turn_rate=(TURN_RATE * turn[0], TURN_RATE * turn[1]),
            orbit=orbited,
            dolly=notches if dollies else 0.0,
            speed=0.0 if dollies else notches,
            fast=any(key in held for key in FAST_KEYS),
        )

    def _held(self) -> set[int]:
        return self._keys | self._tapped


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


def combined(a: Controls, b: Controls) -> Controls:
    """Return what two devices ask for together; the camera limits the sum."""
    move = _summed([a.move, b.move], 3)
    turn = _summed([a.turn, b.turn], 2)
    rate = _summed([a.turn_rate, b.turn_rate], 2)
    orbit = _summed([a.orbit, b.orbit], 2)
    return Controls(
        (move[0], move[1], move[2]),
        (turn[0], turn[1]),
        (rate[0], rate[1]),
        (orbit[0], orbit[1]),
        a.dolly + b.dolly,
        a.speed + b.speed,
        a.fast or b.fast,
    )


def help_rows() -> list[tuple[str, str]]:
    """Return (keys, meaning) of everything that is bound, in reading order."""
    labels: dict[Command, list[str]] = {}
    for item in BINDINGS:
        labels.setdefault(item.command, []).append(item.label)
    rows = list(HELD_HELP)
    for command, names in labels.items():
        text = ", ".join(names) if len(names) <= 2 else f"{names[0]} to {names[-1]}"
        rows.append((text, command.value))
    return rows


def _summed(parts: Sequence[Sequence[float]], count: int) -> list[float]:
    return [sum(part[i] for part in parts) for i in range(count)]


def _past(value: float, dead_zone: float) -> float:
    """Return 0 inside the dead zone and what is beyond it stretched to 0..1."""
    return max(0.0, (value - dead_zone) / (1.0 - dead_zone))


def _stick(value: float) -> float:
    """Return a stick's axis with its dead zone removed, squared for a fine touch."""
    strength = _past(abs(value), STICK_DEAD_ZONE) ** 2
    return strength if value >= 0.0 else -strength
