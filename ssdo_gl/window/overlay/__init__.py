"""What is drawn over the picture with Dear ImGui: values, messages, help, prompts."""

from __future__ import annotations

from ssdo_gl.window.overlay.overlay import Overlay
