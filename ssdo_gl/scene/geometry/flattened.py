"""Instances whose matrix flattens them: to a sheet, which still shows, or to less."""

from __future__ import annotations

import numpy as np

from ssdo_gl.math3d import FloatArray

# Ratio of a matrix's scales below which float64 rounding decides; and the thickness, in
# its stead, that is too thin to see.
_FLAT, _THICKNESS = 1e-12, 1e-4


def with_area(matrices: FloatArray) -> FloatArray:
    """Return those of the matrices (N, 4, 4) that leave an area of what they place.

    What is flattened along one axis still shows; along two it is a line.
    """
    usable = np.asarray(np.isfinite(matrices).all(axis=(1, 2)))
    size = _sizes(np.where(usable[:, None, None], matrices, 0.0))
    return matrices[usable & (size[:, 1] > _FLAT * size[:, 0])]


def thickened(matrices: FloatArray, center: FloatArray | None = None) -> FloatArray:
    """Return the matrices (N, 4, 4), with those that flatten given a little thickness.

    Points level with `center` (3,), by default the origin, stay where they are.

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
    if center is not None:
        result[flat, :3, 3] -= added @ center
    return result


def _sizes(matrices: FloatArray) -> FloatArray:
    """Return the three scales of matrices (N, 4, 4), largest first, (N, 3)."""
    return np.asarray(np.linalg.svd(matrices[:, :3, :3], compute_uv=False), dtype=np.float64)
