"""Wide faces are cut finer where something stands, and each place on them names one surfel."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ssdo_gl.raytracing.bvh import Bvh, build_bvh
from ssdo_gl.raytracing.graded_surfels import graded
from ssdo_gl.raytracing.surfel_points import NOTHING_MET
from ssdo_gl.raytracing.surfels import FIRST_FLAG, SECOND_FLAG, Surfels, build_surfels
from ssdo_gl.raytracing.torn_surfels import torn
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.geometry.shapes import box, quad
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

CAMERA = Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0))
# Widths of the ground, and edge of the box on it; scene units.
GROUND, EDGE = 60.0, 1.0


def ground(sides: int = 4) -> Mesh:
    """Return a square, or half of it, about the origin, z up."""
    corners = GROUND * np.array([[-0.5, -0.5, 0], [0.5, -0.5, 0], [0.5, 0.5, 0], [-0.5, 0.5, 0]])
    return Mesh(corners[:sides], np.array([[0, 1, 2], [0, 2, 3]])[: sides - 2])


def bvh_with(low: float, sides: int = 4, body: Mesh | None = None) -> Bvh:
    """Return a box, or another body, so high over that ground, off its middle and turned."""
    place = np.eye(4)
    place[:2, :2] = EDGE * np.array([[0.8, -0.6], [0.6, 0.8]])
    place[:3, 3] = 7.0, -5.0, low
    body = body or dataclasses.replace(box(), positions=box().positions + [0.0, 0.0, 0.5])
    objects = (SceneObject(0, 0), SceneObject(1, 0, place[None]))
    return build_bvh(Scene((ground(sides), body), (Material(),), objects, CAMERA))


def cut(bvh: Bvh, most: int = 16384) -> tuple[Surfels, Surfels]:
    """Return surfels as they are cut, and graded."""
    whole = build_surfels(bvh, 32768, 0.03, sparse=16384)
    return whole, graded(whole, bvh, most, np.zeros(bvh.triangles.count, dtype=int))


def of_ground(bvh: Bvh, surfels: Surfels) -> np.ndarray:
    """Return which surfels (S,) lie on the front of the ground and are whole."""
    z = bvh.triangles.positions[surfels.sources[:, 0], :, 2]
    flat = np.ptp(z, axis=1) == 0.0
    low = z[:, 0] <= bvh.triangles.positions[..., 2].min() + 1e-6
    return flat & low & (surfels.looks[:, 2] > 0.5) & (surfels.finer == 0)


def at(bvh: Bvh, surfels: Surfels) -> np.ndarray:
    """Return points of surfels (S, 16, 3), scene units."""
    return surfels.positions.astype(float) * bvh.triangles.half_diagonal + bvh.triangles.centre


def named_at(bvh: Bvh, surfels: Surfels, p: np.ndarray) -> int:
    """Return the surfel that a hit from above at `p` names, as shaders/rays/surface_cache.glsl."""
    first, layout = surfels.places.table[0].tolist()
    a, b, c = bvh.triangles.positions[0].astype(float)[[0, 1, 2]] * bvh.triangles.half_diagonal
    turn = int(surfels.places.corner[0])
    a, b, c = np.roll(np.array([a, b, c]) + bvh.triangles.centre, -turn, axis=0)
    weights = np.linalg.solve(np.stack([b - a, c - a], axis=1)[:2], (p - a)[:2])
    outward = weights.sum()
    t = np.array([outward, weights[1] / outward])
    t = np.array([outward, weights[1]]) if layout & FIRST_FLAG else t
    t = np.array([weights[0], outward]) if layout & SECOND_FLAG else t
    grid = np.array([layout & 0xFFF, layout >> 12 & 0xFFF])
    surfel = first
    while True:
        t = t * grid
        cell = np.clip(np.floor(t).astype(int), 0, grid - 1)
        surfel += int(cell[1] * grid[0] + cell[0])
        finer = int(surfels.finer[surfel])
        if not finer:
            return surfel
        t, grid = t - cell, np.array([finer & 15, finer >> 4 & 15])
        surfel = finer >> 8


def test_texels_are_small_beside_a_body_and_grow_with_distance() -> None:
    bvh = bvh_with(0.0)
    whole, fine = cut(bvh)
    chosen = of_ground(bvh, fine)
    points = at(bvh, fine)[chosen]
    widths = np.ptp(points, axis=1).max(axis=1)
    away = np.linalg.norm(points.mean(axis=1)[:, :2] - (7.0, -5.0), axis=1)
    beside = (away > 0.75 * EDGE) & (away < EDGE)
    assert beside.sum() > 50
    assert widths[beside].max() < 0.1 * EDGE
    assert np.all(widths < np.maximum(0.1 * EDGE, away))
    far = away > 10.0 * EDGE
    before = at(bvh, whole)[of_ground(bvh, whole)]
    assert np.ptp(before, axis=1).max() == pytest.approx(widths[far].max(), rel=0.05)
    assert fine.count < 1.3 * whole.count


@pytest.mark.parametrize("sides", [4, 3])
def test_each_place_names_the_surfel_that_lies_there(sides: int) -> None:
    bvh = bvh_with(0.0, sides)
    _, fine = cut(bvh)
    assert (fine.finer > 0).any()
    points = at(bvh, fine)
    chosen = np.flatnonzero(of_ground(bvh, fine))
    for surfel in chosen[:: max(len(chosen) // 300, 1)]:
        # A surfel's points are spread over two triangles, of which one is looked up here.
        inside = points[surfel][fine.sources[surfel] == 0]
        assert {named_at(bvh, fine, p) for p in inside} <= {surfel}


@pytest.mark.parametrize(
    ("low", "body"),
    [(0.001, quad()), (-3.0, None), (30.0, None)],
    ids=["rug", "below", "far above"],
)
def test_what_lies_flat_or_elsewhere_leaves_texels_as_they_are(
    low: float, body: Mesh | None
) -> None:
    _, fine = cut(bvh_with(low, body=body))
    assert not (fine.finer[fine.looks[:, 2] > 0.5] > 0).any()


def test_a_scene_without_wide_faces_stays_as_it_is() -> None:
    whole, fine = cut(build_bvh(Scene((box(),), (Material(),), (SceneObject(0, 0),), CAMERA)))
    assert fine is whole


def test_their_number_is_limited() -> None:
    bvh = bvh_with(0.0)
    whole, all_of_them = cut(bvh)
    _, some = cut(bvh, 400)
    assert all_of_them.count - whole.count > 400
    assert 100 < some.count - whole.count <= 400


def test_what_they_are_cut_into_stays_when_they_move() -> None:
    before, after = bvh_with(0.0), bvh_with(40.0)
    _, fine = cut(before)
    nothing = np.full((fine.count, 16), NOTHING_MET, dtype=np.int64)
    surfels = torn(fine, before, nothing, np.zeros(nothing.shape), 65535)
    moved = surfels.moved(after.triangles)
    assert before.triangles.half_diagonal != after.triangles.half_diagonal
    np.testing.assert_array_equal(moved.planes[:, 3], fine.finer)


def test_parts_of_a_texel_have_what_stands_on_it() -> None:
    """Lines across it are left to them."""
    _, fine = cut(bvh_with(0.0))
    length = fine.lines(np.flatnonzero(fine.finer > 0))[2]
    assert not length.any()
    assert (fine.lines(np.flatnonzero(fine.finer == 0))[2] > 0.0).all(axis=1).mean() > 0.9


def test_quads_of_any_shape_are_cut_where_things_stand() -> None:
    corners = GROUND * np.array([[-0.5, -0.5, 0], [0.5, -0.4, 0], [0.3, 0.5, 0], [-0.4, 0.3, 0]])
    flat = dataclasses.replace(
        quad(), positions=corners, triangles=np.array([[0, 1, 2], [0, 2, 3]])
    )
    place = np.eye(4)
    place[:3, 3] = -9.0, 6.0, 0.5
    objects = (SceneObject(0, 0), SceneObject(1, 0, place[None]))
    bvh = build_bvh(Scene((flat, box()), (Material(),), objects, CAMERA))
    _, fine = cut(bvh)
    points = at(bvh, fine)[of_ground(bvh, fine)]
    nearest = np.argmin(np.linalg.norm(points.mean(axis=1)[:, :2] - (-9.0, 6.6), axis=1))
    assert np.ptp(points[nearest], axis=0).max() < 0.15


def wall_with_strip(
    away: float, sides: int = 1, *, faces_it: bool = True, most: int = 8192
) -> tuple[Surfels, Surfels]:
    """Return the surfels of a wall 4 wide before which a strip 2 wide and .04 high glows, cut."""
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    wall = Mesh(corners * [4.0, 3.0, 1.0], np.array([[0, 1, 2], [0, 2, 3]]))
    order = [[0, 2, 1], [0, 3, 2]] if faces_it else [[0, 1, 2], [0, 2, 3]]
    strip = Mesh(corners * [2.0, 0.04, 1.0] + [1.0, 2.0, away], np.array(order))
    objects = (SceneObject(0, 0), SceneObject(1, 1))
    bvh = build_bvh(Scene((wall, strip), (Material(), Material()), objects, CAMERA))
    whole = build_surfels(bvh, 32768, 0.03)
    return whole, graded(whole, bvh, most, sides * bvh.triangles.material)


def test_texels_are_small_across_the_edges_of_a_lamp_close_to_them() -> None:
    whole, fine = wall_with_strip(0.01)
    assert not (whole.finer > 0).any()
    # The frame's unit is half of the wall's diagonal of 5.
    new = 2.5 * fine.positions[whole.count :].astype(float)
    width, height = np.ptp(new, axis=1)[:, :2].T
    assert (fine.looks[whole.count :, 2] > 0.5).all()
    # Along it they are as before, but at its ends.
    inner = np.abs(new.mean(axis=1)[:, 0]) < 0.8
    assert height[inner].max() < 0.01
    assert inner.sum() > 100
    assert width[inner].min() > 0.04
    assert width[~inner].min() < 0.01


@pytest.mark.parametrize(
    ("away", "sides", "faces_it"),
    [(0.01, 0, True), (0.01, 1, False), (0.3, 1, True), (0.0, 1, True), (-0.01, 1, True)],
    ids=["dark", "facing away", "far off", "touching", "behind"],
)
def test_lamps_that_do_not_light_within_a_texel_leave_it_whole(
    away: float, sides: int, faces_it: bool
) -> None:
    whole, fine = wall_with_strip(away, sides, faces_it=faces_it)
    assert fine is whole


def test_a_lamp_that_faces_away_counts_if_its_back_glows() -> None:
    whole, fine = wall_with_strip(0.01, 2, faces_it=False)
    assert fine.count > whole.count


def test_the_number_of_texels_at_lamps_is_limited() -> None:
    whole, fine = wall_with_strip(0.01)
    _, some = wall_with_strip(0.01, most=200)
    assert fine.count - whole.count > 400
    assert 50 < some.count - whole.count <= 200


def test_many_small_lamps_leave_parts_to_others() -> None:
    """Behind lights at a millimetre there were so many by distance alone that others had none."""
    rows = np.stack(np.meshgrid(np.arange(8), np.arange(6), [0]), axis=-1).reshape(-1, 1, 3)
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    walls = np.concatenate([corners * [4.0, 3.0, 1.0] + [5.0 * i, 0.0, 0.0] for i in range(2)])
    small = 0.02 * corners + [0.3, 0.3, 0.001] + 0.4 * rows
    strip = corners * [2.0, 0.04, 1.0] + [6.0, 2.0, 0.01]
    lamps = np.concatenate([small.reshape(-1, 3), strip])
    joined = Mesh(walls, quads_of(2)), Mesh(lamps, quads_of(len(lamps) // 4)[:, ::-1])
    materials = (Material(), Material())
    bvh = build_bvh(Scene(joined, materials, (SceneObject(0, 0), SceneObject(1, 1)), CAMERA))
    whole = build_surfels(bvh, 32768, 0.03)
    fine = graded(whole, bvh, 4096, bvh.triangles.material)
    place = at(bvh, fine)[whole.count :].mean(axis=1)
    behind = np.abs(place - [7.0, 2.02, 0.0]) < [0.8, 0.05, 0.001]
    assert behind.all(axis=1).sum() > 30
    assert (place[:, 0] < 4.0).sum() > 500


def quads_of(count: int) -> np.ndarray:
    """Return the triangles of so many quads, corner by corner."""
    return (4 * np.arange(count)[:, None, None] + [[0, 1, 2], [0, 2, 3]]).reshape(-1, 3)
