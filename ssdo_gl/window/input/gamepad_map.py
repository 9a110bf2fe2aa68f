"""From a gamepad's axes and buttons to controls."""

from __future__ import annotations

from collections.abc import Sequence

import glfw

from ssdo_gl.window.camera import Controls
from ssdo_gl.window.input.input_map import TURN_RATE

# A stick at rest reports up to a tenth of its way; a trigger is quieter.
STICK_DEAD_ZONE = 0.15
TRIGGER_DEAD_ZONE = 0.05


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
