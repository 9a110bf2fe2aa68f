"""Instances whose matrix flattens them: to a sheet, which still shows, or to less."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, doubled_area_vectors
from ssdo_gl.scene.geometry.mesh import Mesh

# Ratio of a matrix's scales below which float64 rounding decides; and the thickness, in
# its stead, that is too thin to see.
_FLAT, _THICKNESS = 1e-12, 1e-4
# Cosine between a triangle's normal and the way in which it is flattened, below which float32
# decides: it is flattened to a line.
_EDGE_ON = 1e-5
_CHUNK = 256


def with_area(matrices: FloatArray) -> FloatArray:
    """Return those of the matrices (N, 4, 4) that leave an area of what they place.

    What is flattened along one axis still shows; along two it is a line.
    """
    usable = np.asarray(np.isfinite(matrices).all(axis=(1, 2)))
    size = _sizes(np.where(usable[:, None, None], matrices, 0.0))
    return matrices[usable & (size[:, 1] > _FLAT * size[:, 0])]


def thickened(matrices: FloatArray, mesh: Mesh | None = None) -> FloatArray:
    """Return the matrices (N, 4, 4), with those that flatten given a little thickness.

    Those that flatten all triangles of `mesh` to lines are left out. Points level with its
    middle, without a mesh with the origin, stay where they are.

    A matrix without inverse says nothing of which side is the front. As its determinant
    is not negative, the winding on screen stays, as glTF has it.
    """
    size = _sizes(matrices)
    flat = size[:, 2] <= _FLAT * size[:, 0]
    if not flat.any():
        return matrices
    left, size, right = np.linalg.svd(matrices[flat, :3, :3])
    turned = np.linalg.det(left) * np.linalg.det(right)
    thickness = _THICKNESS * size[:, 1] * turned
    added = thickness[:, None, None] * left[:, :, 2:] * right[:, 2:, :]
    result = matrices.copy()
    result[flat, :3, :3] += added
    if mesh is None:
        return result
    result[flat, :3, 3] -= added @ mesh.center()
    shows = ~flat
    shows[flat] = _leave_area(mesh, right[:, 2])
    return result[shows]


def _leave_area(mesh: Mesh, ways: FloatArray) -> NDArray[np.bool_]:
    """Return whether some triangle keeps an area (N,) when flattened along unit vectors (N, 3)."""
    leave = np.zeros(len(ways), dtype=bool)
    # Most are decided by the first triangles.
    for start in range(0, len(mesh.triangles), _CHUNK):
        corners = mesh.positions[mesh.triangles[start : start + _CHUNK]].astype(np.float64)
        normals = doubled_area_vectors(corners)
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        normals /= np.maximum(length, np.finfo(np.float64).tiny)
        leave[~leave] = (np.abs(normals @ ways[~leave].T) > _EDGE_ON).any(axis=0)
        if leave.all():
            break
    return leave


def _sizes(matrices: FloatArray) -> FloatArray:
    """Return the three scales of matrices (N, 4, 4), largest first, (N, 3)."""
    return np.asarray(np.linalg.svd(matrices[:, :3, :3], compute_uv=False), dtype=np.float64)
