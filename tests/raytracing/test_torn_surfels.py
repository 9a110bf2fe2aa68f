"""Surfels that are torn stay where they are on what bears them, wherever that goes."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ssdo_gl.raytracing.bvh import Bvh, build_bvh
from ssdo_gl.raytracing.surfel_points import LIFT, NOTHING_MET, POINT_COUNT
from ssdo_gl.raytracing.surfels import build_surfels
from ssdo_gl.raytracing.torn_surfels import TornSurfels, torn
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.geometry.shapes import box, quad
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

CAMERA = Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0))
# Positions are float32 within [-1, 1], and so are the corners they are made from.
ROUNDING = 4e-7


def bvh_with_box_at(x: float) -> Bvh:
    """Return a square floor of side 4 with a cube of 1 on its middle, or moved along x."""
    floor, cube = np.diag([4.0, 4.0, 1.0, 1.0]), np.eye(4)
    floor[:2, 3], cube[:3, 3] = -2.0, (x, 0.0, 0.5)
    objects = (SceneObject(0, 0, floor[None]), SceneObject(1, 0, cube[None]))
    flat = Mesh(quad().positions, quad().triangles)
    return build_bvh(Scene((flat, box()), (Material(),), objects, CAMERA))


def torn_by_the_box(bvh: Bvh) -> TornSurfels:
    """Return surfels of which the first of the floor's is torn by a side of the cube."""
    surfels = build_surfels(bvh, 65535, 0.2)
    met = np.full((surfels.count, POINT_COUNT), NOTHING_MET, dtype=np.int64)
    x = bvh.triangles.positions[bvh.primitive_triangles.reshape(-1), :, 0]
    side = int(np.flatnonzero((np.ptp(x, axis=1) < 1e-6) & (x[:, 0] > 0.0))[0])
    floor = int(np.flatnonzero(surfels.looks[:, 2] > 0.9)[0])
    met[floor] = side
    return torn(surfels, bvh, met, np.full(met.shape, 0.05), 65535)


def test_points_move_with_their_triangles_and_no_others() -> None:
    before, after = bvh_with_box_at(0.0), bvh_with_box_at(0.7)
    surfels = torn_by_the_box(before)
    moved = surfels.moved(after.triangles)
    unit = before.triangles.half_diagonal
    # The floor is four times as wide.
    is_box = np.ptp(surfels.triangles.positions[surfels.sources[:, 0]], axis=1).max(axis=1) < 1.0
    shift = (moved.positions - surfels.positions) * unit
    expected = np.where(is_box[:, None, None], [0.7, 0.0, 0.0], 0.0)
    np.testing.assert_allclose(shift, np.broadcast_to(expected, shift.shape), atol=ROUNDING * unit)
    assert 0 < is_box.sum() < len(is_box)
    np.testing.assert_array_equal(moved.normals, surfels.normals)


def test_moving_keeps_nothing_for_the_next_time() -> None:
    # What scenes of many triangles kept of all points, float64, was 21 MiB.
    surfels = torn_by_the_box(bvh_with_box_at(0.0))
    surfels.moved(bvh_with_box_at(0.7).triangles)
    assert set(vars(surfels)) == {field.name for field in dataclasses.fields(surfels)}


def test_where_nothing_moves_nothing_is_made() -> None:
    surfels = torn_by_the_box(bvh_with_box_at(0.0))
    assert surfels.moved(surfels.triangles) is surfels


def test_walls_stay_where_they_are_in_another_frame() -> None:
    before = bvh_with_box_at(0.0)
    surfels = torn_by_the_box(before)
    first = int(np.flatnonzero(surfels.others)[0])
    # As if something far away had come into the scene.
    grown = dataclasses.replace(
        before.triangles,
        positions=((before.triangles.positions - [0.5, 0.0, 0.0]) / 3.0).astype(np.float32),
        centre=before.triangles.centre + [0.5 * before.triangles.half_diagonal, 0.0, 0.0],
        half_diagonal=3.0 * before.triangles.half_diagonal,
    )
    moved = surfels.moved(grown)

    def distance(of: TornSurfels) -> np.ndarray:
        normal, reach = of.planes[first, :3], of.planes[first, 3]
        return (of.positions[[first, of.others[first]]] @ normal - reach) * unit_of[id(of)]

    unit_of = {id(surfels): 1.0, id(moved): 3.0}
    np.testing.assert_allclose(distance(moved), distance(surfels), atol=3.0 * (LIFT + ROUNDING))


def test_only_so_many_are_torn_as_there_is_room_for() -> None:
    bvh = bvh_with_box_at(0.0)
    surfels = build_surfels(bvh, 65535, 0.2)
    met = np.zeros((surfels.count, POINT_COUNT), dtype=np.int64)
    result = torn(surfels, bvh, met, np.full(met.shape, 0.05), surfels.count + 3)
    assert result.count == surfels.count + 3


@pytest.mark.parametrize("room", [1, 2])
def test_a_corner_has_its_third_part_where_there_is_room(room: int) -> None:
    bvh = bvh_with_box_at(0.0)
    surfels = build_surfels(bvh, 65535, 0.2)
    corners = bvh.triangles.positions[bvh.primitive_triangles.reshape(-1)]
    edge = corners[..., 0].max(where=np.ptp(corners[..., 2], axis=1)[:, None] > 1e-6, initial=-1.0)
    sides = [
        int(np.flatnonzero((np.ptp(at, axis=1) < 1e-6) & (np.abs(at[:, 0] - edge) < 1e-6))[0])
        for at in (corners[..., 0], corners[..., 1])
    ]
    away = np.linalg.norm(surfels.positions.mean(axis=1)[:, :2] - edge, axis=1)
    floor = int(np.argmin(np.where(surfels.looks[:, 2] > 0.9, away, np.inf)))
    met = np.full((surfels.count, POINT_COUNT), NOTHING_MET, dtype=np.int64)
    met[floor, ::2], met[floor, 1::2] = sides
    result = torn(surfels, bvh, met, np.full(met.shape, 0.05), surfels.count + room)
    assert result.count == surfels.count + room
    assert np.count_nonzero(result.others) == room
