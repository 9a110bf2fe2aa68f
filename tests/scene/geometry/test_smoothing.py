"""Smooth normals against shapes whose normals are known."""

from __future__ import annotations

import dataclasses
import time

import numpy as np
import pytest

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.geometry import mesh as mesh_module
from ssdo_gl.scene.geometry import shapes, smoothing
from ssdo_gl.scene.geometry.mesh import Mesh, smoothed
from ssdo_gl.scene.geometry.topology import spans


def soup(mesh: Mesh) -> Mesh:
    """Return the triangles with corners of their own, as an STL file has them."""
    count = 3 * len(mesh.triangles)
    return Mesh(mesh.positions[mesh.triangles].reshape(-1, 3), np.arange(count).reshape(-1, 3))


def corner_normals(mesh: Mesh) -> FloatArray:
    if mesh.normals is None:
        return mesh.face_normals()[:, None].repeat(3, 1)
    return mesh.normals[mesh.triangles]


def test_a_sphere_has_the_normals_of_a_sphere() -> None:
    mesh = smoothed(soup(shapes.sphere(48, 0.0, 8.0)), 45.0)
    assert mesh.normals is not None
    outward = mesh.positions / np.linalg.norm(mesh.positions, axis=1, keepdims=True)
    # Between the 48 meridians the facets lean by 7.5 degrees.
    assert np.einsum("ij,ij->i", mesh.normals, outward).min() > np.cos(np.radians(2.0))
    assert len(mesh.positions) < len(mesh.triangles)


def test_a_box_keeps_its_edges_and_its_faces() -> None:
    box = soup(shapes.box())
    mesh = smoothed(box, 45.0)
    assert mesh.normals is None
    # The sides of a hexagonal prism lean by 60 degrees.
    wedge = smoothed(soup(shapes.cylinder(6)), 45.0)
    assert wedge.normals is None
    wedge = smoothed(soup(shapes.cylinder(6)), 61.0)
    # Twelve places, each with the normal of its sides and that of its cap.
    assert wedge.normals is not None and len(wedge.positions) == 24


def test_angles_weigh_so_that_triangulation_does_not_matter() -> None:
    """The corner of a box, smooth all over: its diagonal, however faces are divided."""
    mesh = smoothed(soup(shapes.box()), 180.0)
    assert mesh.normals is not None and len(mesh.positions) == 8
    expected = np.sign(mesh.positions) / np.sqrt(3.0)
    np.testing.assert_allclose(mesh.normals, expected, atol=1e-9)


@pytest.mark.parametrize(("crease", "is_smooth"), [(29.0, False), (31.0, True)])
def test_the_crease_angle_decides(crease: float, is_smooth: bool) -> None:
    """Twelve sides lean by 30 degrees from one another; caps stay flat."""
    prism = soup(shapes.cylinder(12))
    mesh = smoothed(prism, crease)
    normals = corner_normals(mesh)
    faces = prism.face_normals()
    is_side = np.abs(faces[:, 2]) < 0.5
    flat = np.allclose(normals[is_side], faces[is_side][:, None], atol=1e-6)
    assert flat is not is_smooth
    np.testing.assert_allclose(normals[~is_side], faces[~is_side][:, None].repeat(3, 1), atol=1e-9)


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
def test_size_does_not_matter(scale: float) -> None:
    mesh = soup(shapes.cylinder(12))
    scaled = dataclasses.replace(mesh, positions=mesh.positions * scale)
    one, other = smoothed(mesh, 40.0), smoothed(scaled, 40.0)
    np.testing.assert_allclose(corner_normals(one), corner_normals(other), atol=1e-6)


def test_colours_and_coordinates_go_along() -> None:
    mesh = soup(shapes.box())
    uvs = np.random.default_rng(1).random((36, 2))
    result = smoothed(dataclasses.replace(mesh, uvs=uvs), 45.0)
    assert result.uvs is not None
    np.testing.assert_array_equal(result.uvs[result.triangles], uvs[mesh.triangles])


def test_a_fan_of_thousands_is_read_in_time() -> None:
    """All creased and in one vertex: the pairs of its triangles would not fit into memory."""
    count = 20_000
    angle = np.arange(count) * (2.0 * np.pi / count)
    rim = np.stack([np.cos(angle), np.sin(angle), np.where(np.arange(count) % 2, 4.0, -4.0)], 1)
    around = np.arange(count)
    fan = np.stack([np.full(count, count), around, np.roll(around, -1)], axis=1)
    positions = np.concatenate([rim, np.zeros((1, 3))])
    start = time.process_time()
    mesh = smoothed(Mesh(positions, fan), 45.0)
    assert time.process_time() - start < 5.0
    np.testing.assert_array_equal(mesh.positions[mesh.triangles], positions[fan])


@pytest.mark.parametrize("crease", [10.0, 180.0])
def test_long_meshes_are_smoothed_as_short_ones(
    crease: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    mesh = soup(shapes.sphere(24, 0.0, 8.0))
    whole = smoothed(mesh, crease)
    for module in (smoothing, mesh_module):
        monkeypatch.setattr(module, "spans", lambda count: spans(count, 7))
    parts = smoothed(mesh, crease)
    for name in ("positions", "triangles", "normals"):
        np.testing.assert_array_equal(getattr(parts, name), getattr(whole, name))
