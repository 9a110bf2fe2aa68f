"""What each key and mouse button asks for: the one table, from which the help is made."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import glfw

from ssdo_gl.math3d import Vector


class Command(StrEnum):
    """What a key can ask for once; the value is what the help says of it."""

    CAPTURE = "look with the mouse, until Esc"
    RELEASE = "let go of the mouse, close the help, hide handles"
    FOCUS = "turn to the point under the cursor and approach it"
    FIT = "fit the scene into the view"
    HOME = "back to where the scene begins"
    NEXT_CAMERA = "next camera of the file"
    PROJECT = "parallel rays, or back to a pinhole camera"
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
    OPEN = "open a model, scene or preset"
    RELOAD_SCENE = "read the scene file again"
    SAVE_SCENE = "save a scene file that renders this picture"
    SCREENSHOT = "picture and settings to files"
    SAVE_PICTURE = "save a picture of any size and method"
    SAVE_PRESET = "settings to a file for --preset"
    COPY_COMMAND = "copy the command that renders this view"
    MATERIAL = "edit what the surface under the cursor is made of"
    UNDO = "undo the last edit"
    REDO = "redo what was undone"
    RESET = "lights, materials, sky, settings and camera as they were at the start"
    STORE = "keep this view as bookmark 1 to 9"
    RECALL = "go to bookmark 1 to 9"
    RECORD = "record a camera path, or end it"
    PLAY = "play the camera path, or stop"
    EXPORT = "export the camera path as a film"
    TOGGLE_PANEL = "show or hide the panel"
    TOGGLE_HELP = "show or hide the list of keys"
    FULLSCREEN = "fill the screen, or back"
    GOVERNOR = "hold the time budget, or not"
    VSYNC = "wait for the display, or not"
    RELOAD = "compile shaders that have changed"
    QUIT = "leave"
    # Of the mouse; the help has a line for each.
    PIVOT = "take the point under the cursor as the centre of what follows"
    ZOOM = "come closer to the point under the cursor, or go away from it"


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


_CONTROL_SHIFT = glfw.MOD_CONTROL | glfw.MOD_SHIFT
_DIGITS = (*range(glfw.KEY_1, glfw.KEY_9 + 1), glfw.KEY_0)
BINDINGS: tuple[Binding, ...] = (
    Binding("F", glfw.KEY_F, Command.FIT),
    Binding("Home", glfw.KEY_HOME, Command.HOME),
    Binding("N", glfw.KEY_N, Command.NEXT_CAMERA),
    Binding("O", glfw.KEY_O, Command.PROJECT),
    Binding("B", glfw.KEY_B, Command.COLLIDE),
    Binding("M", glfw.KEY_M, Command.CAPTURE),
    Binding("Esc", glfw.KEY_ESCAPE, Command.RELEASE),
    *(Binding(str(i % 10), k, Command.VIEW, 0, i) for i, k in enumerate(_DIGITS, 1)),
    Binding("T", glfw.KEY_T, Command.NEXT_METHOD),
    Binding("Shift+T", glfw.KEY_T, Command.PREVIOUS_METHOD, glfw.MOD_SHIFT),
    Binding("V", glfw.KEY_V, Command.SPLIT),
    Binding("Y", glfw.KEY_Y, Command.NEXT_OTHER_METHOD),
    Binding("X", glfw.KEY_X, Command.ERROR),
    Binding("I", glfw.KEY_I, Command.INSPECT),
    Binding("Space", glfw.KEY_SPACE, Command.PAUSE),
    Binding(".", glfw.KEY_PERIOD, Command.STEP),
    Binding("Ctrl+O", glfw.KEY_O, Command.OPEN, glfw.MOD_CONTROL),
    Binding("F5", glfw.KEY_F5, Command.RELOAD_SCENE),
    Binding("Ctrl+S", glfw.KEY_S, Command.SAVE_SCENE, glfw.MOD_CONTROL),
    Binding("Ctrl+Shift+S", glfw.KEY_S, Command.SAVE_PRESET, _CONTROL_SHIFT),
    Binding("F12", glfw.KEY_F12, Command.SCREENSHOT),
    Binding("Shift+F12", glfw.KEY_F12, Command.SAVE_PICTURE, glfw.MOD_SHIFT),
    Binding("C", glfw.KEY_C, Command.COPY_COMMAND),
    Binding("Ctrl+C", glfw.KEY_C, Command.COPY_COMMAND, glfw.MOD_CONTROL),
    Binding("K", glfw.KEY_K, Command.MATERIAL),
    Binding("Ctrl+Z", glfw.KEY_Z, Command.UNDO, glfw.MOD_CONTROL),
    Binding("Ctrl+Shift+Z", glfw.KEY_Z, Command.REDO, _CONTROL_SHIFT),
    Binding("Ctrl+Y", glfw.KEY_Y, Command.REDO, glfw.MOD_CONTROL),
    Binding("Ctrl+R", glfw.KEY_R, Command.RESET, glfw.MOD_CONTROL),
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
    Binding("Tab", glfw.KEY_TAB, Command.TOGGLE_PANEL),
    Binding("F1", glfw.KEY_F1, Command.TOGGLE_HELP),
    Binding("H", glfw.KEY_H, Command.TOGGLE_HELP),
    Binding("F11", glfw.KEY_F11, Command.FULLSCREEN),
    Binding("G", glfw.KEY_G, Command.GOVERNOR),
    Binding("U", glfw.KEY_U, Command.VSYNC),
    Binding("R", glfw.KEY_R, Command.RELOAD),
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
_MOUSE = (
    ("left button", "orbit around the point under the cursor"),
    ("wheel", "towards the point under the cursor, or away from it"),
    ("right button", "look around; the wheel then sets the speed"),
    ("middle button", "slide the picture along with the cursor"),
    ("double click", Command.FOCUS.value),
)
_FLIGHT = (
    ("W A S D", "fly forward, left, back, right; slower near a surface"),
    ("E Q", "fly up, down"),
    ("Shift", "four times as fast"),
    ("arrow keys", "look around"),
)
# The first command of each group that follows; groups are in the order of `BINDINGS`.
_GROUPS = (
    ("Picture", Command.VIEW),
    ("Animation", Command.PAUSE),
    ("Files", Command.OPEN),
    ("Edits", Command.MATERIAL),
    ("Bookmarks and films", Command.STORE),
    ("Window", Command.TOGGLE_PANEL),
)
_BY_KEY = {(item.key, item.mods): item for item in BINDINGS}
# Caps lock and num lock say nothing about what is meant.
_MEANT = glfw.MOD_SHIFT | glfw.MOD_CONTROL | glfw.MOD_ALT | glfw.MOD_SUPER
CHORD = glfw.MOD_CONTROL | glfw.MOD_ALT | glfw.MOD_SUPER

HelpRows = list[tuple[str, str]]


def binding_of(key: int, mods: int) -> Binding | None:
    """Return what a key is bound to; shift, held for speed, changes no key without its own."""
    mods &= _MEANT
    exact = _BY_KEY.get((key, mods))
    return exact if exact or mods & CHORD else _BY_KEY.get((key, 0))


def help_groups() -> dict[str, HelpRows]:
    """Return (keys, meaning) of everything that is bound, by group, in reading order."""
    labels: dict[Command, list[str]] = {}
    for item in BINDINGS:
        labels.setdefault(item.command, []).append(item.label)
    first = {command: title for title, command in _GROUPS}
    groups: dict[str, HelpRows] = {"Mouse": list(_MOUSE), "Camera": list(_FLIGHT)}
    title = "Camera"
    for command, names in labels.items():
        title = first.get(command, title)
        text = ", ".join(names) if len(names) <= 2 else f"{names[0]} to {names[-1]}"
        groups.setdefault(title, []).append((text, command.value))
    return groups
