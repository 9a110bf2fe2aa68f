"""Sides that see nothing have few surfels, and those that see something more in exchange."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.raytracing.blind_sides import blind_sides
from ssdo_gl.raytracing.bvh import Bvh, build_bvh
from ssdo_gl.raytracing.surfel_patches import patches_of
from ssdo_gl.raytracing.surfel_points import NOTHING_MET, POINT_COUNT
from ssdo_gl.raytracing.surfels import (
    BACK_BLIND,
    BLIND_COARSENESS,
    FRONT_BLIND,
    Surfels,
    build_surfels,
)
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.geometry.shapes import box, quad
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

CAMERA = Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0))
SIZE = 0.1
# Texels of 0.1 of a cube with half-diagonal 1, both sides.
BOX_COUNT = 12 * 12 * 6 * 2


def bvh_of(mesh: Mesh, material: Material | None = None) -> Bvh:
    return build_bvh(Scene((mesh,), (material or Material(),), (SceneObject(0, 0),), CAMERA))


def blind_to(bvh: Bvh, triangle: int, distance: float, share: float = 1.0) -> np.ndarray:
    """Return the blind sides where a share of rays meets a triangle, others nothing."""
    surfels = build_surfels(bvh, 65535, SIZE)
    slots = bvh.primitive_triangles.reshape(-1)
    slot = int(np.flatnonzero(slots == triangle)[0]) if triangle >= 0 else NOTHING_MET
    met = np.full((surfels.count, POINT_COUNT), NOTHING_MET, dtype=np.int64)
    met[:, : round(share * POINT_COUNT)] = slot
    return blind_sides(surfels, bvh, patches_of(bvh), met, np.full(met.shape, distance))


def test_sides_that_meet_nothing_are_blind_and_those_that_meet_a_front_are_not() -> None:
    bvh = bvh_of(box())
    assert blind_to(bvh, -1, 1.0).all()
    assert not blind_to(bvh, 0, 1.0, 1 / POINT_COUNT).any()


@pytest.mark.parametrize("distance", [0.1, 2.0], ids=["of a wall", "of a room"])
def test_the_inside_of_a_body_that_nothing_is_in_is_blind(distance: float) -> None:
    assert blind_to(bvh_of(box()), 0, -distance).all()


@pytest.mark.parametrize(("distance", "is_blind"), [(0.1, True), (0.5, False)])
def test_what_touches_walls_lies_not_within_but_what_is_in_a_room_does(
    distance: float, is_blind: bool
) -> None:
    """One ray of 16 meets a front, the others the inside of a cube of edge 1.15."""
    bvh = bvh_of(box())
    surfels = build_surfels(bvh, 65535, SIZE)
    distances = np.full((surfels.count, POINT_COUNT), -distance)
    distances[:, 0] = distance
    met = np.zeros_like(distances, int)
    assert np.all(blind_sides(surfels, bvh, patches_of(bvh), met, distances) == is_blind)


def test_backs_of_what_encloses_nothing_are_seen() -> None:
    assert not blind_to(bvh_of(quad()), 0, -0.1).any()


def test_few_texels_are_left_alone() -> None:
    bvh = bvh_of(box())
    surfels = build_surfels(bvh, 65535, 0.6)
    met = np.full((surfels.count, POINT_COUNT), NOTHING_MET, dtype=np.int64)
    assert not blind_sides(surfels, bvh, patches_of(bvh), met, np.zeros(met.shape)).any()


def cut(bvh: Bvh, *blind: bool) -> tuple[Surfels, np.ndarray]:
    """Return surfels where fronts or backs are blind, and the numbers that places name."""
    chosen = np.tile(blind, (bvh.triangles.count, 1))
    surfels = build_surfels(bvh, 65535, SIZE, blind=chosen)
    first, layout = surfels.places.table.astype(np.int64).T
    grid = np.stack([layout & 0xFFF, layout >> 12 & 0xFFF], axis=1)
    count = np.zeros(len(grid), dtype=np.int64)
    for flag in (FRONT_BLIND, BACK_BLIND):
        is_coarse = (layout & flag != 0)[:, None]
        count += np.where(is_coarse, -(-grid // BLIND_COARSENESS), grid).prod(axis=1)
    named = {(f, c) for f, c in zip(first, count, strict=True)}
    return surfels, np.concatenate([np.arange(f, f + c) for f, c in sorted(named)])


@pytest.mark.parametrize("blind", [(True, False), (False, True), (True, True)])
def test_the_other_side_is_finer_and_places_name_every_surfel_once(blind) -> None:
    bvh = bvh_of(box())
    surfels, named = cut(bvh, *blind)
    assert build_surfels(bvh, 65535, SIZE).count == BOX_COUNT
    np.testing.assert_array_equal(named, np.arange(surfels.count))
    assert 0.8 * BOX_COUNT < surfels.count <= BOX_COUNT or all(blind)
    side = surfels.faces % 2
    counts = np.bincount(side, minlength=2)
    if not all(blind):
        assert counts[blind.index(False)] > 1.6 * (BOX_COUNT / 2)
    # Backs look inwards, fronts outwards.
    outwards = np.einsum("sk,sk->s", surfels.looks, surfels.positions.mean(axis=1)) > 0.0
    np.testing.assert_array_equal(outwards, side == 0)


def test_where_little_is_spared_all_stays_as_it_was() -> None:
    bvh = bvh_of(box())
    plain = build_surfels(bvh, 65535, SIZE)
    blind = np.zeros((bvh.triangles.count, 2), dtype=bool)
    blind[0] = True
    same = build_surfels(bvh, 65535, SIZE, blind=blind)
    np.testing.assert_array_equal(same.positions, plain.positions)
    np.testing.assert_array_equal(same.places.table, plain.places.table)
