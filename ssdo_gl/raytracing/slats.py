"""Lamps behind louvres, grilles and blinds, whose shadows few points of the lamp alias with."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ssdo_gl.math3d import FloatArray
from ssdo_gl.raytracing.triangles import SceneTriangles
from ssdo_gl.scene.lights import Light, RectangleLight

# A slat's triangle is so many times longer than wide, longer than this share of the lamp's shorter
# edge and narrower than that one; and so many lie before the lamp, within its shorter edge.
LEAST_ASPECT, LEAST_LENGTH, MOST_WIDTH, LEAST_COUNT = 4.0, 0.5, 0.125, 48


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
