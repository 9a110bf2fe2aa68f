"""A stage of the edge-aware filter of taps apart, between pixels in the same light."""

from __future__ import annotations

from typing import Any

from ssdo_gl.graph.frame import Frame
from ssdo_gl.passes.edge_aware_filter import EdgeAwareFilterSettings, uniforms

# Of `lib/edge_aware_filter.glsl`.
_APART = 4


def apart_defines(step: int, *, is_first: bool) -> dict[str, int]:
    """Return the defines of a stage of 3 x 3 taps, `step` pixels apart.

    Of two images of irradiance, of which the second holds depths, negative at contacts, and whose
    light and its variance are known.
    """
    return {
        "SIGNAL_COUNT": 2,
        "IS_VISIBILITY": 0,
        "Z_SIGNALS": 2,
        "IS_FIRST": int(is_first),
        "PARTS_EDGES": 1,
        "IS_OF_GLOSS": 0,
        "USE_NORMALS": 1,
        "STAGE": _APART,
        "STEP": step,
        "STRIDE": 1,
        "KNOWS_NOISE": 1,
        "LEAVES_NOISE": 0,
        "HAS_FACTOR": 0,
    }


def apart_uniforms(frame: Frame, step: int, tolerance: float) -> dict[str, Any]:
    """Return the uniforms of such a stage; `tolerance` as in `Levels`."""
    settings = EdgeAwareFilterSettings()
    return {
        **uniforms(settings, frame),
        "u_depth_tolerance": step * settings.depth_tolerance,
        "u_noise_tolerance": tolerance,
    }
