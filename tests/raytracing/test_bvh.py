"""The hierarchy: every triangle once, every box around what it holds, no needless depth."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hierarchy_walk import check_hierarchy, decode
from hypothesis import given, settings
from hypothesis import strategies as st
from meshes import soup
from numpy.typing import NDArray

from ssdo_gl.raytracing import split, triangles
from ssdo_gl.raytracing.bvh import (
    MAX_RECORDS,
    build_bvh,
    build_from_triangles,
    cached_bvh,
)
from ssdo_gl.raytracing.packed import oct_words
from ssdo_gl.raytracing.pairs import pair_triangles, stable_order, vertex_ids
from ssdo_gl.raytracing.split import MAX_SAH_DEPTH, BinaryTree, build_binary, half_area
from ssdo_gl.raytracing.triangles import SceneTriangles, scene_triangles
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.geometry.shapes import sphere
from ssdo_gl.scene.material import Material, Texture
from ssdo_gl.scene.scene import Scene

CAMERA = Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0))


def grid(count: int) -> Mesh:
    """Return a plane of count x count quadrilaterals with shared vertices."""
    x, y = np.meshgrid(np.arange(count + 1.0), np.arange(count + 1.0), indexing="ij")
    positions = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
    a = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).reshape(-1)
    b, c, d = a + count + 1, a + count + 2, a + 1
    return Mesh(positions, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


def scene_of(*meshes: Mesh, transform: NDArray[np.float64] | None = None) -> Scene:
    matrices = np.eye(4)[None] if transform is None else transform
    objects = tuple(SceneObject(i, 0, matrices) for i in range(len(meshes)))
    return Scene(meshes, (Material(),), objects, CAMERA)


def triangles_of(positions: NDArray[np.float32]) -> SceneTriangles:
    """Return bare triangles (T, 3, 3) of the normalised frame."""
    count = len(positions)
    zeros = np.zeros(count, dtype=np.int32)
    return SceneTriangles(
        positions.astype(np.float32),
        np.zeros((count, 3), dtype=np.uint32),
        np.zeros((count, 3, 2), dtype=np.float32),
        np.zeros((count, 3, 2), dtype=np.uint32),
        zeros,
        zeros - 1,
        zeros > 0,
        zeros > 0,
        zeros > 0,
        np.zeros(3),
        1.0,
    )


@pytest.mark.parametrize("mesh", [soup(1), soup(2), soup(5), soup(700), grid(13)], ids=str)
def test_boxes_hold_their_children_and_every_triangle_is_there_once(mesh: Mesh) -> None:
    check_hierarchy(build_bvh(scene_of(mesh)), len(mesh.triangles))


def test_quadrilaterals_become_one_primitive_each() -> None:
    bvh = build_bvh(scene_of(grid(8)))
    assert len(bvh.primitive_triangles) == 64
    assert np.all(bvh.primitive_triangles >= 0)


def test_pairs_keep_the_winding() -> None:
    mesh = grid(6)
    bvh = build_bvh(scene_of(mesh))
    vertices = np.array([v for _, v in sorted(decode(bvh)[0].items())])
    for columns in ([0, 1, 2], [0, 2, 3]):
        a, b, c = np.moveaxis(vertices[:, columns], 1, 0)
        assert np.all(np.cross(b - a, c - a)[:, 2] > 0.0)


def test_triangles_of_opposite_winding_are_not_paired() -> None:
    mesh = Mesh(
        np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2], [0, 3, 2]])
    )
    assert len(build_bvh(scene_of(mesh)).primitive_triangles) == 2


def test_pairing_goes_by_position_not_by_index() -> None:
    mesh = grid(4)
    unshared = Mesh(mesh.positions[mesh.triangles].reshape(-1, 3), np.arange(96).reshape(-1, 3))
    assert len(pair_triangles(scene_triangles(scene_of(unshared)).positions).triangles) == 16


def test_vertex_ids_are_equal_exactly_for_equal_positions() -> None:
    rng = np.random.default_rng(3)
    points = rng.integers(-2, 3, (500, 3)).astype(np.float32)
    points[::7] *= np.float32(-1.0)  # brings in negative zeros
    ids = vertex_ids(points)
    same = np.all(points[:, None] == points[None], axis=2)
    np.testing.assert_array_equal(ids[:, None] == ids[None], same)


def test_triangles_without_area_are_dropped() -> None:
    positions = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0], [1, 0, 0], [1e-30, 0, 0]])
    triangles = np.array([[0, 1, 2], [0, 1, 3], [1, 4, 2], [0, 5, 2], [0, 0, 0]])
    flat = scene_triangles(scene_of(Mesh(positions, triangles)))
    assert flat.count == 1


def test_a_scene_of_degenerate_triangles_only_has_an_empty_root() -> None:
    mesh = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), np.array([[0, 1, 2]]))
    bvh = build_bvh(scene_of(mesh))
    assert len(bvh.primitive_triangles) == 0
    assert not bvh.records().any()


def test_many_triangles_in_one_place_are_split_by_count() -> None:
    corner = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    bvh = build_from_triangles(triangles_of(np.repeat(corner, 300, axis=0)))
    found, depth = decode(bvh)
    # Single triangles (pairs need opposite edges): 300 leaves, 5 levels of four at best.
    assert len(found) == 300
    assert depth <= 9


def test_depth_stays_bounded_for_hostile_input() -> None:
    # Sizes that halve from triangle to triangle: the heuristic peels off one at a time.
    size = np.exp2(-np.arange(120.0))[:, None, None]
    shape = np.array([[[1.0, 1, 1], [0.9, 1, 1], [1, 0.9, 1]]])
    bvh = build_from_triangles(triangles_of((shape * size).astype(np.float32)))
    decode(bvh)
    assert bvh.depth <= MAX_SAH_DEPTH + 8
    boxes = shape[0, 0] * np.exp2(-np.arange(120.0))[:, None]
    tree = build_binary(boxes * 0.9, boxes)
    assert len(tree.level_starts) <= MAX_SAH_DEPTH + 8


def test_the_heuristic_beats_halving_by_count() -> None:
    mesh = soup(2000, size=0.01)
    corners = mesh.positions.reshape(-1, 3, 3)
    low, high = corners.min(axis=1), corners.max(axis=1)

    def cost(tree_low: NDArray[np.float64], tree_high: NDArray[np.float64]) -> float:
        areas = half_area(tree_low, tree_high)
        return float(areas.sum() / areas[0])

    tree = build_binary(low, high)
    # Boxes of a median split along the axes in turn, for comparison.
    boxes = []

    def halve(members: NDArray[np.int64], axis: int) -> None:
        boxes.append((low[members].min(axis=0), high[members].max(axis=0)))
        if len(members) > 1:
            order = members[np.argsort(low[members, axis])]
            halve(order[: len(order) // 2], (axis + 1) % 3)
            halve(order[len(order) // 2 :], (axis + 1) % 3)

    halve(np.arange(len(low)), 0)
    median = cost(np.array([b[0] for b in boxes]), np.array([b[1] for b in boxes]))
    # Evenly spread soup is the hardest input to gain on; clustered ones gain far more.
    assert cost(tree.low, tree.high) < 0.95 * median


@settings(max_examples=20, deadline=None)
@given(st.integers(1, 60), st.integers(0, 1 << 30), st.sampled_from([1e-6, 0.1, 3.0]))
def test_any_soup_is_built_right(count: int, seed: int, size: float) -> None:
    bvh = build_bvh(scene_of(soup(count, seed, size)))
    decode(bvh)
    used = bvh.primitive_triangles[bvh.primitive_triangles >= 0]
    assert sorted(used) == list(range(bvh.triangles.count))


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
@pytest.mark.parametrize("offset", [0.0, 1e5])
def test_the_frame_is_normalised_whatever_scale_and_place(scale: float, offset: float) -> None:
    mesh = soup(50)
    moved = dataclasses.replace(mesh, positions=mesh.positions * scale + offset)
    reference = scene_triangles(scene_of(mesh))
    flat = scene_triangles(scene_of(moved))
    assert np.abs(flat.positions).max() <= 1.0
    # Positions given at 1e5 have steps of 1.5e-11, relative to the scale.
    tolerance = 2e-7 + 1.5e-11 * offset / 1e5 / scale
    np.testing.assert_allclose(flat.positions, reference.positions, atol=tolerance)
    assert flat.half_diagonal == pytest.approx(reference.half_diagonal * scale, rel=1e-6)


def test_instances_carry_normals_and_mirrored_ones_their_winding() -> None:
    mesh = Mesh(
        np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]),
        np.array([[0, 1, 2]]),
        normals=np.array([[0.0, 0, 1]] * 3),
    )
    matrices = np.stack([np.eye(4), np.diag([-1.0, 1, 1, 1]), np.diag([2.0, 1, -3, 1])])
    flat = scene_triangles(scene_of(mesh, transform=matrices))
    a, b, c = (flat.positions[:, i].astype(np.float64) for i in range(3))
    winding = np.cross(b - a, c - a)
    expected = np.array([[0.0, 0, 1], [0, 0, 1], [0, 0, -1]])
    assert np.all(np.einsum("tk,tk->t", winding, expected) > 0.0)
    np.testing.assert_array_equal(flat.normals[:, 0], oct_words(expected))


@pytest.mark.parametrize(("has_image", "most"), [(False, 75), (True, 100)])
def test_little_is_kept_of_a_triangle(has_image, most) -> None:
    """Bytes beside the nodes: hierarchies stay for as long as their scenes are shown."""
    texture = Texture(np.zeros((1, 1, 4), dtype=np.uint8)) if has_image else None
    scene = scene_of(sphere(40))
    bvh = build_bvh(dataclasses.replace(scene, materials=(Material(albedo_texture=texture),)))
    held = [*vars(bvh.triangles).values(), *vars(bvh).values()]
    arrays = [value for value in held if isinstance(value, np.ndarray)]
    taken = sum(array.nbytes for array in arrays if 0 not in array.strides) - bvh.nodes.nbytes
    assert 50 * bvh.triangles.count < taken < most * bvh.triangles.count


def test_the_cache_knows_content_not_identity() -> None:
    mesh = soup(20)
    first = cached_bvh(scene_of(mesh))
    assert cached_bvh(scene_of(dataclasses.replace(mesh))) is first
    positions = mesh.positions.copy()
    positions[0, 0] += 1e-3
    assert cached_bvh(scene_of(dataclasses.replace(mesh, positions=positions))) is not first
    painted = scene_of(mesh)
    painted = dataclasses.replace(
        painted,
        materials=(Material(), Material()),
        objects=(dataclasses.replace(painted.objects[0], material=1),),
    )
    assert cached_bvh(painted) is not first
    pixels = np.zeros((1, 1, 4), dtype=np.uint8)
    for material in (Material(single_sided=True), Material(albedo_texture=Texture(pixels))):
        assert cached_bvh(dataclasses.replace(scene_of(mesh), materials=(material,))) is not first


def test_the_limit_on_records_is_what_a_waiting_word_can_name() -> None:
    assert MAX_RECORDS == 4 << (32 - 3 - 7)


def surface_of(tree: BinaryTree) -> float:
    """Return what a random ray opens: the surface of all nodes, relative to the root's."""
    areas = half_area(tree.low, tree.high)
    return float(areas[tree.left >= 0].sum() / areas[0])


def test_boxes_of_many_are_split_as_well_as_of_few(monkeypatch: pytest.MonkeyPatch) -> None:
    corners = soup(3000, size=0.02).positions.reshape(-1, 3, 3).astype(np.float32)
    low, high = corners.min(axis=1), corners.max(axis=1)
    exact = build_binary(low, high)
    monkeypatch.setattr(split, "MOST_EXACT", 0)
    tree = build_binary(low, high)
    assert sorted(tree.primitive[tree.left < 0]) == list(range(3000))
    inner = np.flatnonzero(tree.left >= 0)
    children = np.stack([tree.left[inner], tree.left[inner] + 1])
    np.testing.assert_array_equal(tree.low[inner], tree.low[children].min(axis=0))
    np.testing.assert_array_equal(tree.high[inner], tree.high[children].max(axis=0))
    # Children come in later levels than their parents.
    level = np.searchsorted(tree.level_starts, np.arange(len(tree.left)), side="right")
    assert np.all(level[children] > level[inner])
    assert surface_of(tree) < 1.02 * surface_of(exact)


@pytest.mark.parametrize("most", [1, 16])
def test_planes_between_few_members_are_those_of_the_bins(
    most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    corners = soup(500, size=0.1).positions.reshape(-1, 3, 3)
    expected = build_binary(corners.min(axis=1), corners.max(axis=1))
    monkeypatch.setattr(split, "MOST_FEW", most)
    found = build_binary(corners.min(axis=1), corners.max(axis=1))
    np.testing.assert_array_equal(found.primitive, expected.primitive)


@given(st.lists(st.integers(0, 5), max_size=60))
def test_equal_keys_keep_their_order(keys: list[int]) -> None:
    array = np.array(keys, dtype=np.int64)
    expected = np.argsort(array, kind="stable")
    np.testing.assert_array_equal(stable_order(array), expected)


def test_pairs_of_many_triangles_go_by_the_vertices_of_each_copy(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    mesh = grid(5)
    unshared = Mesh(mesh.positions[mesh.triangles].reshape(-1, 3), np.arange(150).reshape(-1, 3))
    copies = np.stack([np.eye(4), np.diag([-1.0, 1, 1, 1])])
    scene = scene_of(unshared, transform=copies)
    few = build_bvh(scene)
    monkeypatch.setattr(triangles, "MANY_TRIANGLES", 0)
    many = build_bvh(scene)
    assert few.triangles.vertices is None
    assert many.triangles.vertices is not None
    assert len(many.primitive_triangles) == len(few.primitive_triangles) == 50
    decode(many)


def test_the_share_of_the_work_that_is_done_grows_to_one() -> None:
    shares: list[float] = []
    build_bvh(scene_of(soup(500)), shares.append)
    assert shares == sorted(shares)
    assert len(shares) > 8
    assert 0.0 < shares[0] < shares[-1] <= 1.0
