"""Points of model files, drawn as small bodies."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray

# A body has 8 triangles: two million in all.
MAX_POINTS = 1 << 18
# Radius relative to the diagonal of the points' bounds: a third of the distance between N
# points on a square, within these ends.
_SPACING_SHARE, _SMALLEST, _LARGEST = 0.33, 0.0005, 0.01
_CORNERS = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
_FACES = np.array(
    [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
)


def point_bodies(
    positions: FloatArray, colors: FloatArray | None
) -> tuple[FloatArray, NDArray[np.int64], FloatArray | None, str]:
    """Return vertices, triangles and colours of an octahedron for each point, and a note.

    Parameters
    ----------
    positions : ndarray, shape (N, 3)
        Those that are not finite are left out; of more than `MAX_POINTS` an even share is
        taken.
    colors : ndarray, shape (N, 4), or None
    """
    count = len(positions)
    chosen = np.flatnonzero(np.isfinite(positions).all(axis=1))
    chosen = chosen[:: max(1, -(-len(chosen) // MAX_POINTS))]
    centers = positions[chosen]
    share = np.clip(_SPACING_SHARE / np.sqrt(max(len(centers), 1)), _SMALLEST, _LARGEST)
    # What overflows is dropped where meshes are cleaned.
    with np.errstate(over="ignore", invalid="ignore"):
        extent = np.ptp(centers, axis=0) if len(centers) else np.zeros(3)
        # A single place has no size of its own.
        radius = float(share) * float(np.linalg.norm(extent)) or _LARGEST
        vertices = (centers[:, None] + radius * _CORNERS).reshape(-1, 3)
    first = len(_CORNERS) * np.arange(len(centers))
    triangles = (first[:, None, None] + _FACES).reshape(-1, 3)
    colored = None if colors is None else np.repeat(colors[chosen], len(_CORNERS), axis=0)
    note = f"{count} points drawn as small bodies"
    if len(centers) < count:
        note += f", {len(centers)} of them"
    return vertices, triangles, colored, note
