"""Images that stay on the device, refined while nothing moves, within a budget."""

from __future__ import annotations

from ssdo_gl.window.live.governor import Governor, QualityLevel, quality_levels
from ssdo_gl.window.live.inspector import (
    INSPECTED,
    Reading,
    clearance,
    inspect,
    shown_values,
    surface_point,
)
from ssdo_gl.window.live.kept_planes import KeptPlanes
from ssdo_gl.window.live.live_image import REFINE_FRAMES, FrameRequest, LiveImage
from ssdo_gl.window.live.monitor import Monitor
