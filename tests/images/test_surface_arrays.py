"""Positions and normals in the world, against the definitions."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl import math3d
from ssdo_gl.graph.frame import FrameView
from ssdo_gl.images.surface_arrays import world_normals, world_positions

FLOAT32_EPSILON = 2.0**-24


def tilted_view(offset=0.0, jitter_px=(0.0, 0.0)):
    position = np.array([1.0, 2.0, 3.0]) + offset
    rotation = math3d.look_rotation(position, position + [0.3, -0.5, -1.0], [0, 1, 0])
    return FrameView((8, 6), position, rotation, (0.9, 0.6), 0.1, 50.0, jitter_px)


@pytest.mark.parametrize("offset", [0.0, 1e5])
@pytest.mark.parametrize("jitter_px", [(0.0, 0.0), (0.25, -0.4)])
def test_positions_invert_the_projection(offset, jitter_px):
    """Each position, projected again, lands on the centre of its own pixel."""
    view = tilted_view(offset, jitter_px)
    rng = np.random.default_rng(3)
    z_vs = rng.uniform(1.0, 20.0, (6, 8, 1)).astype(np.float32)
    z_vs[0, 0] = 0.0
    positions = world_positions(z_vs, view)
    assert positions[0, 0].tolist() == [0.0, 0.0, 0.0]
    # Only the output is float32: its rounding, in pixels of a view 20 units deep.
    tolerance_px = float(8 * (np.abs(positions).max() * FLOAT32_EPSILON) / (0.6 * 1.0))
    clip_from_view = view.clip_from_view
    for row, column in np.argwhere(z_vs[:, :, 0] > 0.0):
        point_vs = view.point_vs(positions[row, column].astype(np.float64))
        clip = clip_from_view @ np.append(point_vs, 1.0)
        pixel = (clip[:2] / clip[3] * 0.5 + 0.5) * view.size
        assert pixel == pytest.approx([column + 0.5, 5 - row + 0.5], abs=max(tolerance_px, 1e-4))
        assert -point_vs[2] == pytest.approx(
            z_vs[row, column, 0], rel=1e-6, abs=2e-2 * (offset > 0)
        )


def test_normals_decode_and_turn_to_the_world():
    view = tilted_view()
    rng = np.random.default_rng(4)
    normals_vs = rng.normal(size=(6, 8, 3))
    normals_vs /= np.linalg.norm(normals_vs, axis=2, keepdims=True)
    projected = normals_vs[:, :, :2] / np.abs(normals_vs).sum(axis=2, keepdims=True)
    lower = (1.0 - np.abs(projected[:, :, ::-1])) * np.where(projected >= 0.0, 1.0, -1.0)
    square = np.where(normals_vs[:, :, 2:] < 0.0, lower, projected)
    # 16-bit codes run from 0 to 65534 of 65535, so that 0 is one of them.
    encoded = (square + 1.0) * (32767.0 / 65535.0)
    stored = np.concatenate([encoded, encoded], axis=2).astype(np.float32)
    z_vs = np.ones((6, 8, 1), np.float32)
    z_vs[2, 3] = 0.0
    result = world_normals(stored, z_vs, view)
    assert result[2, 3].tolist() == [0.0, 0.0, 0.0]
    expected = normals_vs @ view.view_from_world
    hit = z_vs[:, :, 0] > 0.0
    # The stored float32 numbers are good to 6e-8; decoding divides by at least 1/3.
    np.testing.assert_allclose(result[hit], expected[hit], atol=1e-6)
