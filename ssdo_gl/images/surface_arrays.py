"""World-space positions and normals of what the camera saw, from the G-buffer's arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.graph.frame import FrameView

Image = NDArray[np.float32]


def world_positions(z_vs: Image, view: FrameView) -> Image:
    """Return world-space positions (height, width, 3), 0 where nothing was hit.

    Parameters
    ----------
    z_vs : ndarray, shape (height, width, 1)
        Distance along the view axis, scene units, row 0 at the top; 0 = background.

    Notes
    -----
    Computed in float64: far from the origin, adding the camera's position in float32
    would lose what the view-space depth resolves. The result itself is float32.
    """
    height, width = z_vs.shape[:2]
    x = 2.0 * (np.arange(width) + 0.5) / width - 1.0 + view.jitter_ndc[0]
    y = 1.0 - 2.0 * (np.arange(height) + 0.5) / height + view.jitter_ndc[1]
    z = z_vs[:, :, 0].astype(np.float64)
    half_x, half_y = (
        half + tangent * z for half, tangent in zip(view.half_frame, view.tan_half_fov, strict=True)
    )
    position_vs = np.stack([x[None, :] * half_x, y[:, None] * half_y, -z], axis=2)
    position_ws = position_vs @ view.view_from_world + view.position_ws
    return np.where(z_vs > 0.0, position_ws, 0.0).astype(np.float32)


def camera_depths(z_vs: Image, view: FrameView) -> Image:
    """Return distances along the view axis from the camera, 0 where nothing was hit."""
    if view.depth_offset == 0.0:
        return z_vs
    return np.where(z_vs > 0.0, z_vs + np.float64(view.depth_offset), 0.0).astype(np.float32)


def world_normals(normals_vs: Image, z_vs: Image, view: FrameView) -> Image:
    """Return unit shading normals in world space (height, width, 3), 0 at the background.

    Parameters
    ----------
    normals_vs : ndarray, shape (height, width, 4)
        Octahedral shading normal in the first two channels, [0, 1].
    z_vs : ndarray, shape (height, width, 1)
    """
    # 0 is step 32767 of 65535, see shaders/lib/octahedral.glsl.
    encoded = normals_vs[:, :, :2].astype(np.float64) * (65535.0 / 32767.0) - 1.0
    z = 1.0 - np.abs(encoded).sum(axis=2)
    folded = (1.0 - np.abs(encoded[:, :, ::-1])) * np.where(encoded >= 0.0, 1.0, -1.0)
    xy = np.where(z[:, :, None] < 0.0, folded, encoded)
    normal = np.concatenate([xy, z[:, :, None]], axis=2)
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    return np.where(z_vs > 0.0, normal @ view.view_from_world, 0.0).astype(np.float32)
