"""The picture of a window: one or two methods that draw a scene, side by side."""

from __future__ import annotations

from ssdo_gl.window.canvas.canvas import DEFAULT_BUDGET_MS, Canvas, without_line
from ssdo_gl.window.canvas.presenter import error_color
