"""Positions and normals of a G-buffer that was read back, in float64."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ssdo_gl.graph.frame import FrameView
from ssdo_gl.math3d import FloatArray


def positions_vs(z_vs: ArrayLike, view: FrameView) -> FloatArray:
    """Return view-space positions (height, width, 3) of a depth image, top row first.

    Background pixels (depth 0) come out at the camera.
    """
    z = np.asarray(z_vs, np.float64).reshape(view.size[1], view.size[0])
    x = 2.0 * (np.arange(view.size[0]) + 0.5) / view.size[0] - 1.0 + view.jitter_ndc[0]
    y = 1.0 - 2.0 * (np.arange(view.size[1]) + 0.5) / view.size[1] + view.jitter_ndc[1]
    return np.stack(
        [z * (x * view.tan_half_fov[0]), z * (y * view.tan_half_fov[1])[:, None], -z], axis=-1
    )


def positions_ws(z_vs: ArrayLike, view: FrameView) -> FloatArray:
    """Return world-space positions (height, width, 3); background at the camera."""
    return np.asarray(positions_vs(z_vs, view) @ view.view_from_world + view.position_ws)


def normals_vs(codes: ArrayLike) -> FloatArray:
    """Return unit normals (..., 3) of octahedral codes (..., 2), the inverse of `oct_encode`.

    `codes` is one pair of channels of ``normals_vs``: ``[..., :2]`` holds the shading
    normal, ``[..., 2:]`` the geometric one.
    """
    # 0 is step 32767 of the 16-bit range, see shaders/lib/octahedral.glsl.
    p = np.asarray(codes, np.float64) * (65535.0 / 32767.0) - 1.0
    z = 1.0 - np.abs(p).sum(axis=-1)
    fold = np.maximum(-z, 0.0)[..., None]
    n = np.concatenate([p - fold * np.where(p < 0.0, -1.0, 1.0), z[..., None]], axis=-1)
    return np.asarray(n / np.linalg.norm(n, axis=-1, keepdims=True))


def normals_ws(codes: ArrayLike, view: FrameView) -> FloatArray:
    """Return unit normals in world space; see `normals_vs`."""
    return np.asarray(normals_vs(codes) @ view.view_from_world)
