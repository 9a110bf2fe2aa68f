"""Faces that surfels are cut from: pairs of triangles in one plane, and single triangles."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, IntArray, doubled_area_vectors
from ssdo_gl.raytracing.bvh import Bvh

# Two triangles of a pair share a grid if their normals enclose less than 0.8 degrees.
COPLANAR_COSINE = 0.9999
# Triangles share a surfel if this many times their normals round to the same numbers:
# 1.4 keeps (1, 0, 0), and all that is within 20 degrees of it, apart from others.
NORMAL_STEPS = 1.4


@dataclass(frozen=True, eq=False)
class Patches:
    """Faces that may have a grid of texels.

    `corners` are v0 to v3 of a pair, and v0, v1, v2, v2 of a triangle; its grid has one axis
    from v0 outwards and the other across.
    """

    corners: FloatArray  # (N, 4, 3)
    normals: FloatArray  # (N, 3), unit
    areas: FloatArray  # (N,)
    is_joint: NDArray[np.bool_]
    slots: IntArray  # (N, 2): of both triangles, the same twice of a single one
    sides: IntArray  # (N,): 1 or 2

    @cached_property
    def centres(self) -> FloatArray:
        """Means of their corners (N, 3)."""
        return np.asarray(self.corners.mean(axis=1))

    @cached_property
    def looks(self) -> IntArray:
        """Which way they look, about: one of 27 numbers, (N,)."""
        steps = np.rint(NORMAL_STEPS * self.normals).astype(np.int64) + 1
        return np.asarray(steps @ np.array([9, 3, 1]))

    def extents(self) -> FloatArray:
        """Return the lengths (N, 2) along both axes of the grid."""
        v0, v1, v2, v3 = np.moveaxis(self.corners, 1, 0)
        edges = [np.linalg.norm(d, axis=1) for d in (v1 - v0, v2 - v3, v3 - v0, v2 - v1)]
        outward = np.maximum(edges[0], edges[2])
        joint = np.stack([np.maximum(edges[0], edges[1]), np.maximum(edges[2], edges[3])], 1)
        return np.where(self.is_joint[:, None], joint, np.stack([outward, edges[3]], 1))


def patches_of(bvh: Bvh) -> Patches:
    """Return the faces of all primitives of a hierarchy."""
    triangles, pair, corner = bvh.triangles, bvh.primitive_triangles, bvh.primitive_corners
    positions = triangles.positions.astype(np.float64)
    first = positions[pair[:, :1], corner[:, 0]]
    second = positions[np.maximum(pair[:, 1:], 0), corner[:, 1]]
    normals_1, areas_1 = _normals(first)
    normals_2, areas_2 = _normals(second)
    single_sided = triangles.single_sided[np.maximum(pair, 0)]
    has_second = pair[:, 1] >= 0
    joint = has_second & (single_sided[:, 0] == single_sided[:, 1])
    joint &= np.einsum("nk,nk->n", normals_1, normals_2) > COPLANAR_COSINE
    alone = has_second & ~joint
    last = np.where(joint[:, None], second[:, 2], first[:, 2])
    quads = np.concatenate([first, last[:, None]], axis=1)
    rest = np.concatenate([second, second[:, 2:]], axis=1)[alone]
    slot = 2 * np.arange(len(pair))
    return Patches(
        np.concatenate([quads, rest]),
        np.concatenate([normals_1, normals_2[alone]]),
        np.concatenate([areas_1 + np.where(joint, areas_2, 0.0), areas_2[alone]]),
        np.concatenate([joint, np.zeros(alone.sum(), dtype=bool)]),
        np.concatenate([np.stack([slot, slot + joint], 1), np.stack([slot + 1] * 2, 1)[alone]]),
        2 - np.concatenate([single_sided[:, 0], single_sided[alone, 1]]).astype(np.int64),
    )


def _normals(corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return unit normals (N, 3) and areas of triangles (N, 3, 3)."""
    doubled = doubled_area_vectors(corners)
    length = np.linalg.norm(doubled, axis=1)
    return doubled / np.maximum(length, np.finfo(np.float64).tiny)[:, None], 0.5 * length
