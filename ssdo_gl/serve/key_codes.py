"""From what browsers call keys and buttons to GLFW's numbers, which `bindings` has.

By where a key is (``KeyboardEvent.code``), as GLFW does, not by what it types.
"""

from __future__ import annotations

import glfw

_LETTERS = {f"Key{letter}": ord(letter) for letter in "ABCDEFGHIJKLMNOPQRSTUVWXYZ"}
_DIGITS = {f"Digit{digit}": ord(str(digit)) for digit in range(10)}
_FUNCTIONS = {f"F{i}": glfw.KEY_F1 + i - 1 for i in range(1, 13)}
_OTHERS = {
    "Space": glfw.KEY_SPACE,
    "Period": glfw.KEY_PERIOD,
    "Home": glfw.KEY_HOME,
    "Escape": glfw.KEY_ESCAPE,
    "Tab": glfw.KEY_TAB,
    "ArrowLeft": glfw.KEY_LEFT,
    "ArrowRight": glfw.KEY_RIGHT,
    "ArrowUp": glfw.KEY_UP,
    "ArrowDown": glfw.KEY_DOWN,
    "ShiftLeft": glfw.KEY_LEFT_SHIFT,
    "ShiftRight": glfw.KEY_RIGHT_SHIFT,
}
KEYS: dict[str, int] = {**_LETTERS, **_DIGITS, **_FUNCTIONS, **_OTHERS}
# ``MouseEvent.button`` counts from left to right.
BUTTONS = (glfw.MOUSE_BUTTON_LEFT, glfw.MOUSE_BUTTON_MIDDLE, glfw.MOUSE_BUTTON_RIGHT)
