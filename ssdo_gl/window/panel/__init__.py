"""The panel over the picture: every setting, lights, times and reasons."""

from __future__ import annotations

from ssdo_gl.window.panel.menu import TEXT_FACTORS, draw_menu
from ssdo_gl.window.panel.panel import Panel, panel_width
from ssdo_gl.window.panel.status import state_text
