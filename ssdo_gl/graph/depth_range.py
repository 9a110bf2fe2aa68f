"""Which kind of 24-bit depth a view needs; see ``shaders/lib/depth_test.glsl``."""

from __future__ import annotations

import math

# Up to this far / near the hyperbolic depth resolves 1e-6 of z at the far plane, as the
# logarithmic one does at any ratio. That one gives up the early depth test of GPUs, yet
# costs nothing that can be measured on llvmpipe.
HYPERBOLIC_DEPTH_RATIO = 16.0
# The far plane lies this many times as far as the farthest bound. Clip space ends at
# z / w = 1, which a surface at the bound then misses by 2 near / far (1 - 1 / 4): 1.5e-6 at
# least, a dozen roundings of float32. With the plane at the bound, rounding alone would
# cut surfaces off.
FAR_PLANE_FACTOR = 4.0


def far_plane(far: float) -> float:
    """Return where to put the far plane so that nothing up to `far` is clipped."""
    return far * FAR_PLANE_FACTOR


def wide_depth_range(near: float, far: float) -> int:
    """Return the define ``WIDE_DEPTH_RANGE`` for clip distances `near` and `far`."""
    return int(far > HYPERBOLIC_DEPTH_RATIO * near)


def depth_uniforms(near: float, far: float) -> dict[str, object]:
    """Return the uniforms of ``lib/depth_test.glsl``."""
    if not wide_depth_range(near, far):
        return {}
    scale = 1.0 / math.log2(far / near)
    return {"u_log_depth": (scale, -math.log2(near) * scale)}
