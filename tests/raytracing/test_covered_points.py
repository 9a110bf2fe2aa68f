"""Rays of surfels start from open points, where something covers others."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, IntArray
from ssdo_gl.raytracing.bvh import build_bvh
from ssdo_gl.raytracing.covered_points import covered, enclosed, uncovered
from ssdo_gl.raytracing.packed import unit_vectors
from ssdo_gl.raytracing.surfel_points import NOTHING_MET, POINT_COUNT
from ssdo_gl.raytracing.surfels import build_surfels
from ssdo_gl.raytracing.torn_surfels import torn
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.geometry.shapes import box
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

CAMERA = Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0))


def test_what_is_met_straight_on_covers() -> None:
    bvh = build_bvh(Scene((box(),), (Material(),), (SceneObject(0, 0),), CAMERA))
    a, b, c = np.moveaxis(bvh.triangles.positions[bvh.primitive_triangles[0, 0]], 0, 0)
    normal = np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a))
    along = (b - a) / np.linalg.norm(b - a)
    tilted = [np.cos(t) * normal + np.sin(t) * along for t in np.radians([0.0, 5.0, 10.0])]
    ways = np.array([[*tilted, -normal, normal]])
    met = np.array([[0, 0, 0, 0, NOTHING_MET]])
    assert covered(bvh, met, ways).tolist() == [[True, True, False, True, False]]


def test_open_points_stand_in_for_covered_ones() -> None:
    bvh = build_bvh(Scene((box(),), (Material(),), (SceneObject(0, 0),), CAMERA))
    surfels = build_surfels(bvh, 65535, 0.2)
    met = np.full((surfels.count, POINT_COUNT), NOTHING_MET, dtype=np.int64)
    whole = torn(surfels, bvh, met, np.full(met.shape, 0.05), surfels.count)
    covered = np.zeros((whole.count, POINT_COUNT), dtype=bool)
    covered[:2] = True
    covered[0, [1, 3]] = False
    found = uncovered(whole, covered)
    for name in ("positions", "normals", "sources"):
        before, after = getattr(whole, name), getattr(found, name)
        open_ones = before[0, [1, 3]]
        np.testing.assert_array_equal(after[0, [1, 3]], open_ones)
        assert all((point == open_ones).reshape(2, -1).all(axis=1).any() for point in after[0])
        # Nothing stands in where all are covered.
        np.testing.assert_array_equal(after[1:], before[1:])
    # As often one as the other.
    at = (found.positions[0] == whole.positions[0, 1]).all(axis=1)
    assert np.count_nonzero(at) == POINT_COUNT // 2


def test_points_of_fronts_within_another_body_are_enclosed() -> None:
    bvh = build_bvh(Scene((box(),), (Material(),), (SceneObject(0, 0),), CAMERA))
    surfels = build_surfels(bvh, 65535, 0.2)
    met = np.full((surfels.count, POINT_COUNT), NOTHING_MET, dtype=np.int64)
    whole = torn(surfels, bvh, met, np.full(met.shape, 0.05), surfels.count)
    # A ball about a point, no wider than a surfel: from within rays meet it from behind.
    middle = whole.positions[0, 0].astype(np.float64)
    radius = 0.4 * float(np.linalg.norm(np.ptp(whole.positions, axis=1), axis=1).min())

    def trace(
        starts: NDArray[np.float32], ways: FloatArray, reach: FloatArray
    ) -> tuple[IntArray, FloatArray]:
        to_middle = middle - starts
        along = np.einsum("spk,spk->sp", to_middle, ways)
        left = radius**2 - np.einsum("spk,spk->sp", to_middle, to_middle)
        away = along + np.sqrt(np.maximum(along**2 + left, 0.0))
        is_met = (left > 0.0) & (away <= reach)
        # One point sees out, another a front.
        is_met.flat[out], away.flat[front] = False, -away.flat[front]
        return np.where(is_met, 0, NOTHING_MET), np.where(is_met, -away, 0.0)

    inside = np.linalg.norm(whole.positions - middle, axis=-1) < radius
    is_front = np.einsum("spk,spk->sp", unit_vectors(whole.normals), whole.positions) > 0.0
    expected = inside & is_front
    out, front = np.flatnonzero(expected)[:2]
    assert expected.sum() > 2 and (inside & ~is_front).any()
    expected.flat[[out, front]] = False
    np.testing.assert_array_equal(enclosed(whole, trace), expected)
