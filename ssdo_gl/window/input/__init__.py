"""Keys, mouse and gamepad: which of them ask for what."""

from __future__ import annotations

from ssdo_gl.window.input.bindings import BINDINGS, Action, Command, help_groups
from ssdo_gl.window.input.input_map import InputMap, combined, gamepad_controls
