"""Cleaning of triangle lists, telling solids from open surfaces, the box around a mesh."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ssdo_gl.scene.geometry import Mesh, cleaned_mesh, shapes, topology
from ssdo_gl.scene.geometry.topology import is_closed, joined_vertices

TRIANGLE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
FACE = np.array([[0, 1, 2]])


@given(exponent=st.integers(-12, 12))
def test_a_triangle_has_area_at_every_scale(exponent: int) -> None:
    cleaned = cleaned_mesh(Mesh(TRIANGLE * 10.0**exponent, FACE))
    assert cleaned.mesh is not None
    assert cleaned.zero_area == 0
    assert cleaned.mesh.face_normals().tolist() == [[0.0, 0.0, 1.0]]


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_collinear_and_collapsed_triangles_are_dropped_at_every_scale(scale: float) -> None:
    line = np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0], [2.0, 4.0, 6.0]]) * scale
    assert cleaned_mesh(Mesh(line, FACE)).mesh is None
    assert cleaned_mesh(Mesh(line, FACE)).zero_area == 1
    point = np.ones((3, 3)) * scale
    assert cleaned_mesh(Mesh(point, FACE)).mesh is None
    assert cleaned_mesh(Mesh(TRIANGLE * scale, np.array([[0, 1, 1]]))).mesh is None


def test_a_thin_triangle_is_kept() -> None:
    thin = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 1e-9, 0.0]])
    assert cleaned_mesh(Mesh(thin, FACE)).mesh is not None


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_triangles_with_a_bad_corner_are_dropped_and_counted(bad: float) -> None:
    positions = np.concatenate([TRIANGLE, [[bad, 0.0, 0.0]]])
    cleaned = cleaned_mesh(Mesh(positions, np.array([[0, 1, 2], [0, 1, 3], [1, 2, 3]])))
    assert cleaned.not_finite == 2
    assert cleaned.mesh is not None
    assert len(cleaned.mesh.positions) == 3  # the bad vertex went with its triangles
    assert len(cleaned.mesh.triangles) == 1


@pytest.mark.parametrize("index", [3, -1])
def test_an_index_out_of_range_is_an_error(index: int) -> None:
    with pytest.raises(ValueError, match=f"vertex {index} of 3"):
        cleaned_mesh(Mesh(TRIANGLE, np.array([[0, 1, index]])))


@pytest.mark.parametrize("bad", [0.0, np.nan, np.inf])
def test_unusable_normals_become_the_face_normal(bad: float) -> None:
    normals = np.array([[0.0, 0.0, 2.0], [bad, bad, bad], [0.0, 3.0, 4.0]])
    cleaned = cleaned_mesh(Mesh(TRIANGLE, FACE, normals))
    assert cleaned.bad_normals == 1
    assert cleaned.mesh is not None
    assert cleaned.mesh.normals is not None
    assert np.allclose(cleaned.mesh.normals, [[0, 0, 1], [0, 0, 1], [0, 0.6, 0.8]])


def test_tiny_normals_are_directions_too() -> None:
    cleaned = cleaned_mesh(Mesh(TRIANGLE, FACE, np.full((3, 3), 1e-200)))
    assert cleaned.bad_normals == 0
    assert cleaned.mesh is not None
    assert np.allclose(cleaned.mesh.normals, 1.0 / np.sqrt(3.0))


def test_a_mesh_without_normals_stays_without() -> None:
    cleaned = cleaned_mesh(Mesh(TRIANGLE, FACE))
    assert cleaned.mesh is not None
    assert cleaned.mesh.normals is None


def test_a_solid_with_a_hole_is_open() -> None:
    mesh = shapes.sphere(16)
    assert is_closed(mesh.positions, mesh.triangles)
    assert not is_closed(mesh.positions, mesh.triangles[1:])


def test_a_solid_with_one_face_turned_is_open() -> None:
    mesh = shapes.box()
    turned = mesh.triangles.copy()
    turned[0] = turned[0, ::-1]
    assert not is_closed(mesh.positions, turned)


def test_a_solid_with_a_doubled_face_is_open() -> None:
    mesh = shapes.box()
    assert not is_closed(mesh.positions, np.concatenate([mesh.triangles, mesh.triangles[:1]]))


def test_solids_that_share_an_edge_are_not_one_solid() -> None:
    mesh = shapes.box()
    positions = np.concatenate([mesh.positions, mesh.positions + [1.0, 1.0, 0.0]])
    assert not is_closed(positions, np.concatenate([mesh.triangles, mesh.triangles + 24]))


def test_two_solids_that_do_not_touch_are_closed_together() -> None:
    mesh = shapes.box()
    positions = np.concatenate([mesh.positions, mesh.positions + 5.0])
    assert is_closed(positions, np.concatenate([mesh.triangles, mesh.triangles + 24]))


def test_vertices_join_where_positions_are_equal() -> None:
    positions = np.array([[0.0, 1.0, 2.0], [0.0, 1.0, 2.0], [-0.0, 1.0, 2.0], [0.0, 1.0, 3.0]])
    label = joined_vertices(positions)
    assert label[0] == label[1] == label[2]
    assert label[3] != label[0]


@given(st.lists(st.tuples(*[st.integers(0, 2)] * 3), min_size=1, max_size=30))
def test_labels_agree_with_comparing_all_pairs(rows: list[tuple[int, int, int]]) -> None:
    positions = np.array(rows, dtype=np.float64)
    label = joined_vertices(positions)
    equal = (positions[:, None] == positions[None]).all(axis=2)
    assert np.array_equal(label[:, None] == label[None], equal)


def test_positions_of_one_key_are_told_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(topology, "_position_keys", lambda p: np.zeros(len(p), dtype=np.uint64))
    rows = [(0, 0, 0), (1, 0, 0), (0, 0, 0), (0, 1, 0), (1, 0, 0)]
    assert joined_vertices(np.array(rows, dtype=np.float64)).tolist() == [0, 1, 0, 3, 1]


# The last vertex belongs to no triangle.
POSITIONS = np.array([[1.0, -2, 3], [0, 5, 0], [-4, 1, 1], [99, 99, 99]])


def test_bounds_hold_what_is_drawn_and_no_more() -> None:
    low, high = Mesh(POSITIONS, np.array([[0, 1, 2]])).bounds()
    assert low.tolist() == [-4.0, -2.0, 0.0]
    assert high.tolist() == [1.0, 5.0, 3.0]


def test_bounds_are_found_out_once_and_cannot_be_spoilt() -> None:
    mesh = Mesh(POSITIONS, np.array([[0, 1, 2]]))
    assert mesh.bounds()[0] is mesh.bounds()[0]
    with pytest.raises(ValueError, match="read-only"):
        mesh.bounds()[1][0] = 7.0
    larger = dataclasses.replace(mesh, positions=2.0 * POSITIONS)
    assert larger.bounds()[0].tolist() == [-8.0, -4.0, 0.0]
