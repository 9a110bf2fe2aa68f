"""The panel over the picture: every setting, lights, times and reasons."""

from __future__ import annotations

from ssdo_gl.window.panel.panel import Panel, panel_width

__all__ = ["Panel", "panel_width"]
