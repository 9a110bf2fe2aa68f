"""Louvres, grilles and blinds: lamps behind them, and the faces of their slats.

Few points of such a lamp alias with its shadows. On a slat light falls off within its width, from
the edge that the sun shines on to the one that others shade.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, IntArray
from ssdo_gl.raytracing.surfel_patches import Patches
from ssdo_gl.raytracing.surfel_points import NOTHING_MET
from ssdo_gl.raytracing.surfels import Surfels
from ssdo_gl.raytracing.triangles import SceneTriangles
from ssdo_gl.scene.lights import Light, RectangleLight

# A slat's triangle is so many times longer than wide, longer than this share of the lamp's shorter
# edge and narrower than that one; and so many lie before the lamp, within its shorter edge.
LEAST_ASPECT, LEAST_LENGTH, MOST_WIDTH, LEAST_COUNT = 4.0, 0.5, 0.125, 48
# A slat's face is so many times longer than wide, and of what it sees so much at least is another
# that faces it, within so many of its widths. With 4 times courtyard has 1.4 times as many
# surfels, and errs as before; with less than .17 faces of cornell_meso are slats.
FACE_ASPECT, LEAST_FACING, REACH, FACING_COSINE = 5.5, 0.17, 3.0, 0.95

# Triangles looked at together, so that millions of them need little memory.
CHUNK = 1 << 18


def slats_of(triangles: SceneTriangles) -> FloatArray:
    """Return middle, length and width of all narrow triangles, (N, 5), scene units."""
    positions = triangles.positions
    parts = [
        _narrow(positions[i : i + CHUNK].astype(np.float64))
        for i in range(0, len(positions), CHUNK)
    ]
    found = np.concatenate([np.zeros((0, 5)), *parts]) * triangles.half_diagonal
    found[:, :3] += triangles.centre
    return found


def _narrow(corners: FloatArray) -> FloatArray:
    edges = np.roll(corners, -1, axis=1) - corners
    length = np.sqrt(np.einsum("tck,tck->tc", edges, edges).max(axis=1))
    width = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1) / np.maximum(length, 1e-30)
    is_narrow = length > LEAST_ASPECT * width
    sizes = np.stack([length, width], axis=1)[is_narrow]
    return np.concatenate([corners[is_narrow].mean(axis=1), sizes], axis=1)


def lamps_behind(slats: FloatArray, lights: Sequence[Light]) -> frozenset[int]:
    """Return which lights are rectangles close behind many slats."""
    return frozenset(
        i
        for i, light in enumerate(lights)
        if isinstance(light, RectangleLight) and _slats_before(slats, light) >= LEAST_COUNT
    )


def _slats_before(slats: FloatArray, lamp: RectangleLight) -> int:
    u, v = np.array(lamp.edge_u), np.array(lamp.edge_v)
    edge, normal = min(np.linalg.norm(u), np.linalg.norm(v)), np.cross(u, v)
    if not normal.any():
        return 0
    fits = (slats[:, 3] > LEAST_LENGTH * edge) & (slats[:, 4] < MOST_WIDTH * edge)
    from_corner = slats[fits, :3] - lamp.corner
    place = from_corner @ np.linalg.inv(np.stack([u, v, normal / np.linalg.norm(normal)], axis=1)).T
    height = np.abs(place[:, 2]) if lamp.two_sided else place[:, 2]
    is_before = np.all(np.abs(place[:, :2] - 0.5) < 1.0, axis=1)
    return int(np.sum(is_before & (height > 0.0) & (height < edge)))


def slat_faces(
    surfels: Surfels, patches: Patches, met: IntArray, distances: FloatArray
) -> NDArray[np.bool_]:
    """Return which patches (N,) are narrow and face others that are, too, close to them.

    Parameters are as those of `blind_sides.blind_sides`.
    """
    extents = patches.extents()
    is_narrow = extents.max(axis=1) > FACE_ASPECT * extents.min(axis=1)
    chosen = np.flatnonzero((surfels.faces >= 0) & is_narrow[np.maximum(surfels.faces, 0) // 2])
    if not len(chosen):
        return np.zeros(len(extents), dtype=bool)
    is_met = met[chosen] != NOTHING_MET
    patch_of = np.zeros(patches.slots.max() + 1, dtype=np.int64)
    patch_of[patches.slots.T] = np.arange(len(extents))
    own, other = surfels.faces[chosen, None] // 2, patch_of[np.where(is_met, met[chosen], 0)]
    cosine = np.einsum("sik,srk->sr", patches.normals[own], patches.normals[other])
    # From behind rays meet what encloses them, as the other face of the same slat.
    far = REACH * extents.min(axis=1)[own]
    is_near = is_met & (distances[chosen] > 0.0) & (distances[chosen] < far)
    faces_it = is_near & is_narrow[other] & (np.abs(cosine) > FACING_COSINE)
    beyond = np.bincount(
        surfels.faces[chosen], faces_it.mean(axis=1) - LEAST_FACING, 2 * len(extents)
    )
    return np.asarray((beyond > 0.0).reshape(-1, 2).any(axis=1))
