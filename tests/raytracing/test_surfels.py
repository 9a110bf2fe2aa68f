"""Surfels cover all surfaces once, and never both sides of anything."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ssdo_gl.raytracing.bvh import Bvh, build_bvh
from ssdo_gl.raytracing.surfel_points import POINT_COUNT
from ssdo_gl.raytracing.surfels import FIRST_FLAG, SECOND_FLAG, Surfels, build_surfels
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.geometry.shapes import box, cone, quad, sphere, torus
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

CAMERA = Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0))


def bvh_of(mesh: Mesh, material: Material | None = None) -> Bvh:
    return build_bvh(Scene((mesh,), (material or Material(),), (SceneObject(0, 0),), CAMERA))


def numbers(surfels: Surfels, sides: int = 2) -> np.ndarray:
    """Return the numbers of all surfels that the places name, each as often as named."""
    first, layout = surfels.places.table.astype(np.int64).T
    counts = (layout & 0xFFF) * (layout >> 12 & 0xFFF) * sides
    named = {(f, c) for f, c in zip(first, counts, strict=True) if c}
    return np.concatenate([np.arange(f, f + c) for f, c in sorted(named)])


@pytest.mark.parametrize("mesh", [quad(), box(), sphere(), cone(), torus(0.3)])
@pytest.mark.parametrize("size", [0.05, 0.4])
def test_places_name_every_surfel_once(mesh, size) -> None:
    surfels = build_surfels(bvh_of(mesh), 65535, size)
    np.testing.assert_array_equal(numbers(surfels), np.arange(surfels.count))


def test_their_number_is_limited() -> None:
    surfels = build_surfels(bvh_of(sphere()), 500, 0.01)
    assert 250 < surfels.count <= 500


def test_single_sided_surfaces_have_one_side() -> None:
    both = build_surfels(bvh_of(quad()), 65535, 0.1)
    front = build_surfels(bvh_of(quad(), Material(single_sided=True)), 65535, 0.1)
    assert front.count * 2 == both.count


def test_points_of_a_quad_lie_in_their_texel() -> None:
    surfels = build_surfels(bvh_of(quad()), 65535, 0.2)
    assert np.all(surfels.places.table[:, 1] & (FIRST_FLAG | SECOND_FLAG))
    nu, nv = (int(surfels.places.table[0, 1]) >> shift & 0xFFF for shift in (0, 12))
    at = surfels.positions[: nu * nv].astype(np.float64)
    spread = np.sort(np.ptp(at, axis=1), axis=1)
    # Of a unit square with half-diagonal 1 edges are sqrt(2) long.
    assert np.all(spread[:, 1:] < np.sqrt(2.0) / min(nu, nv))
    np.testing.assert_allclose(at.mean(axis=(0, 1))[:2], 0.0, atol=0.01)
    assert np.all(at[..., 2] > 0.0) and np.all(surfels.positions[nu * nv :, :, 2] < 0.0)


def test_both_faces_of_a_thin_wall_stay_apart() -> None:
    mesh = sphere(96)
    flat = Mesh(mesh.positions * (1.0, 1.0, 1e-3), mesh.triangles)
    surfels = build_surfels(bvh_of(flat), 65535, 0.5)
    height = np.sign(surfels.positions[..., 2])
    thick = np.abs(surfels.positions[..., 2]).min(axis=1) > 1e-5
    assert thick.sum() > 10
    assert np.all(np.abs(height[thick].sum(axis=1)) == POINT_COUNT)


def test_a_scene_without_triangles_has_none_that_shine() -> None:
    flat = Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]]))
    assert build_surfels(bvh_of(flat), 64, 0.1).count == 1


@pytest.mark.parametrize(
    ("most", "spare", "across"), [(65535, 0, 6), (200, 0, 3), (150, 24, 3), (150, 23, 1)]
)
def test_a_strip_keeps_its_edges_apart_where_there_is_room(
    most: int, spare: int, across: int
) -> None:
    """Sun on the outer edge of a slat is not sent from the inner one."""
    slat = dataclasses.replace(quad(), positions=quad().positions * [10.0, 0.3, 1.0])
    surfels = build_surfels(bvh_of(slat), most, 0.07, spare)
    layout = int(surfels.places.table[0, 1])
    assert sorted((layout & 0xFFF, layout >> 12 & 0xFFF)) == [across, 29]


@pytest.mark.parametrize("width", [0.05, 0.3])
def test_slats_are_cut_across_however_few_surfels_they_are_long(width: float) -> None:
    slat = dataclasses.replace(quad(), positions=quad().positions * [2.0, width, 1.0])
    surfels = build_surfels(bvh_of(slat), 65535, 0.2, slats=np.ones(1, dtype=bool))
    layout = int(surfels.places.table[0, 1])
    assert sorted((layout & 0xFFF, layout >> 12 & 0xFFF)) == [6, 10]


def on_a_ground(width: float, boxes: int = 1) -> Bvh:
    """Return boxes of edge 2 that stand in a row on a square, from its middle on."""
    ground = dataclasses.replace(quad(), positions=quad().positions * width - [0.0, 0.0, 1.01])
    room = dataclasses.replace(box(), positions=box().positions * 2.0)
    places = np.tile(np.eye(4), (boxes, 1, 1))
    places[:, 0, 3] = 3.0 * np.arange(boxes)
    objects = (SceneObject(0, 0), SceneObject(1, 0, places))
    return build_bvh(Scene((ground, room), (Material(),), objects, CAMERA))


def cut(bvh: Bvh) -> tuple[Surfels, np.ndarray]:
    """Return surfels as a scene has them, and texels along edges."""
    surfels = build_surfels(bvh, 32768, 0.03, sparse=16384)
    layout = surfels.places.table[:, 1].astype(np.int64)
    return surfels, np.stack([layout & 0xFFF, layout >> 12 & 0xFFF], axis=1)


# By texels of .03 alone a room would have one or two along each edge.
@pytest.mark.parametrize(("width", "least"), [(20.0, 16), (60.0, 16), (600.0, 8)])
def test_texels_of_a_room_are_fine_on_a_wide_ground(width: float, least: int) -> None:
    surfels, texels = cut(on_a_ground(width))
    assert texels[2:].min() >= least
    assert surfels.count <= 16384


def test_texels_of_several_rooms_are_a_quarter_as_wide_if_the_limit_allows_it() -> None:
    # 5 where 16384 were not exceeded.
    surfels, texels = cut(on_a_ground(20.0, boxes=5))
    assert texels[2:].min() >= 16
    assert 16384 < surfels.count <= 32768


def test_a_wide_ground_keeps_its_texels_and_so_does_a_scene_without_empty_space() -> None:
    for bvh, chosen in ((on_a_ground(600.0), slice(2)), (bvh_of(box()), slice(None))):
        plain = build_surfels(bvh, 65535, 0.03).places.table[chosen, 1]
        fine = build_surfels(bvh, 65535, 0.03, sparse=16384).places.table[chosen, 1]
        assert np.array_equal(plain, fine)
