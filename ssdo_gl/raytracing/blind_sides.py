"""Sides of faces that need few surfels, because they see nothing that they could light.

The outside of a room that stands alone sees no surface, and the inside of its walls, which are
bodies, nothing but itself. Of a room of boxes both are three quarters of all faces.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, IntArray
from ssdo_gl.raytracing.bvh import Bvh
from ssdo_gl.raytracing.surfel_patches import Patches
from ssdo_gl.raytracing.surfel_points import NOTHING_MET
from ssdo_gl.raytracing.surfels import Surfels

# A side of fewer texels may see what few rays miss, and would spare little.
LEAST_TEXELS = 8
# The inside of a wall is told from that of a room by how far it reaches, in widths of the face;
# what touches the wall from outside may seem to lie within.
THICKNESS, LEAST_ENCLOSED = 0.25, 0.75


def blind_sides(
    surfels: Surfels, bvh: Bvh, patches: Patches, met: IntArray, distances: FloatArray
) -> NDArray[np.bool_]:
    """Return which fronts and backs (N, 2) of the patches of a hierarchy are blind.

    Parameters
    ----------
    patches : Patches
        Those of the hierarchy.
    met : ndarray, shape (S, R)
        What each ray of each surfel meets: 2 p + s for triangle s of primitive p, or
        `NOTHING_MET`.
    distances : ndarray, shape (S, R)
        How far along the ray, normalised frame; negative where it is met from behind.
    """
    is_met = met != NOTHING_MET
    triangle = bvh.primitive_triangles.reshape(-1)[np.where(is_met, met, 0)]
    is_within = is_met & (distances < 0.0) & bvh.triangles.solid[triangle]
    own = surfels.faces >= 0

    def summed(values: NDArray[np.generic]) -> FloatArray:
        """Return sums over the rays of each side."""
        of_surfel = values.sum(axis=1)[own]
        return np.bincount(surfels.faces[own], of_surfel, 2 * len(patches.sides)).astype(float)

    rays, within = summed(np.ones(met.shape)), summed(is_within)
    sees = summed(is_met & ~is_within) > 0.0
    reach = summed(np.where(is_within, -distances, 0.0)) / np.maximum(within, 1.0)
    width = np.repeat(patches.extents().min(axis=1), 2)
    is_wall = (within >= LEAST_ENCLOSED * rays) & (reach < THICKNESS * width)
    blind = (rays >= LEAST_TEXELS * met.shape[1]) & (~sees | is_wall)
    return np.asarray(blind.reshape(-1, 2))
