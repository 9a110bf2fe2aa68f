"""Normals of the far field's probes, as ``shaders/lib/far_probes.glsl`` keeps them."""

from __future__ import annotations

import numpy as np

CODE_BASE, HALF_RANGE = 0x20000000, 8191.0


def code_of(normal):
    """Return the code of a normal that looks up: the two numbers of its octahedron's square."""
    x, y = np.rint((normal[:2] / np.abs(normal).sum() + 1.0) * HALF_RANGE).astype(np.uint32)
    return np.uint32(CODE_BASE + (x | y << 14)).view(np.float32)
