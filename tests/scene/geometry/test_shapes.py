"""Primitive shapes: closed, outward, and as large as geometry says."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from meshes import area

from ssdo_gl.scene.geometry import shapes
from ssdo_gl.scene.geometry.mesh import Mesh
from ssdo_gl.scene.geometry.topology import is_closed

# Float64 sums over at most 16 thousand triangles.
ROUNDING = 1e-12

SOLIDS = {
    "box": shapes.box(),
    "sphere": shapes.sphere(),
    "coarse sphere": shapes.sphere(3),
    "bumpy sphere": shapes.sphere(128, 0.15, 9.0),
    "cylinder": shapes.cylinder(),
    "coarse cylinder": shapes.cylinder(3),
    "cone": shapes.cone(),
    "torus": shapes.torus(0.3),
    "half torus": shapes.torus(0.3, 180.0),
    "thin arc": shapes.torus(0.05, 10.0, 16, 8),
}


def volume(mesh: Mesh) -> float:
    """Return the enclosed volume; positive if the faces look outward."""
    a, b, c = (mesh.positions[mesh.triangles[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


@pytest.mark.parametrize("mesh", SOLIDS.values(), ids=SOLIDS.keys())
def test_solids_are_closed_and_face_outward(mesh: Mesh) -> None:
    assert mesh.closed
    assert is_closed(mesh.positions, mesh.triangles)
    assert volume(mesh) > 0.0


@pytest.mark.parametrize("mesh", [*SOLIDS.values(), shapes.quad()])
def test_every_triangle_is_usable(mesh: Mesh) -> None:
    assert np.isfinite(mesh.face_normals()).all()
    assert mesh.triangles.dtype == np.int64
    assert mesh.triangles.min() == 0
    assert mesh.triangles.max() < len(mesh.positions)
    assert mesh.uvs is not None
    assert mesh.uvs.shape == (len(mesh.positions), 2)
    assert mesh.uvs.min() >= 0.0
    assert mesh.uvs.max() <= 1.0


@pytest.mark.parametrize("name", [name for name in SOLIDS if name != "box"])
def test_smooth_normals_are_unit_and_agree_with_the_faces(name: str) -> None:
    mesh = SOLIDS[name]
    assert mesh.normals is not None
    assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=ROUNDING)
    agreement = np.einsum("tvk,tk->tv", mesh.normals[mesh.triangles], mesh.face_normals())
    # Around a triangle normals turn by 60 degrees within a face, and more from pole to
    # equator of the coarsest sphere (acos 1 / sqrt 5); finer shapes turn less.
    assert agreement.min() > (0.44 if "coarse" in name else 0.9)


def test_flat_shapes_are_shaded_flat() -> None:
    assert shapes.box().normals is None
    assert shapes.quad().normals is None


def test_box_is_the_unit_cube() -> None:
    mesh = shapes.box()
    low, high = mesh.bounds()
    assert low.tolist() == [-0.5] * 3
    assert high.tolist() == [0.5] * 3
    assert volume(mesh) == pytest.approx(1.0, abs=ROUNDING)
    assert area(mesh) == pytest.approx(6.0, abs=ROUNDING)


def test_quad_front_is_edge_u_cross_edge_v() -> None:
    mesh = shapes.quad()
    assert mesh.face_normals().tolist() == [[0.0, 0.0, 1.0]] * 2
    assert mesh.bounds()[1].tolist() == [1.0, 1.0, 0.0]
    assert not mesh.closed


def test_quad_texture_stands_upright() -> None:
    mesh = shapes.quad()
    assert mesh.uvs is not None
    top = mesh.positions[:, 1] == 1.0
    # v = 0 is the top row of the image.
    assert mesh.uvs[top, 1].tolist() == [0.0, 0.0]
    assert np.array_equal(mesh.uvs[:, 0], mesh.positions[:, 0])


@given(segments=st.integers(3, 96))
def test_cylinder_is_a_regular_prism(segments: int) -> None:
    mesh = shapes.cylinder(segments)
    step = 2.0 * np.pi / segments
    base = 0.5 * segments * np.sin(step)
    side = 2.0 * segments * np.sin(step / 2.0)
    assert volume(mesh) == pytest.approx(base, rel=1e-12)
    assert area(mesh) == pytest.approx(2.0 * base + side, rel=1e-12)


@given(segments=st.integers(3, 96))
def test_cone_is_a_regular_pyramid(segments: int) -> None:
    mesh = shapes.cone(segments)
    step = 2.0 * np.pi / segments
    base = 0.5 * segments * np.sin(step)
    slant = np.hypot(1.0, np.cos(step / 2.0))
    assert volume(mesh) == pytest.approx(base / 3.0, rel=1e-12)
    assert area(mesh) == pytest.approx(base + segments * np.sin(step / 2.0) * slant, rel=1e-12)


def test_sphere_vertices_lie_on_the_sphere_and_face_out() -> None:
    mesh = shapes.sphere()
    assert np.allclose(np.linalg.norm(mesh.positions, axis=1), 1.0, atol=ROUNDING)
    assert np.array_equal(mesh.positions, mesh.normals)


def test_sphere_converges_to_the_closed_form_with_second_order() -> None:
    exact = 4.0 / 3.0 * np.pi
    errors = [exact - volume(shapes.sphere(n)) for n in (32, 64, 128)]
    assert errors[2] > 0.0  # inscribed
    # Halving the edges quarters the error; 2 % covers the next order.
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.02)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.02)


@pytest.mark.parametrize(("tube", "arc"), [(0.3, 360.0), (0.1, 360.0), (0.25, 90.0)])
def test_torus_converges_to_pappus(tube: float, arc: float) -> None:
    share = arc / 360.0
    exact_volume = 2.0 * np.pi**2 * tube**2 * share
    ends = 0.0 if arc == 360.0 else 2.0 * np.pi * tube**2
    exact_area = 4.0 * np.pi**2 * tube * share + ends
    mesh = shapes.torus(tube, arc, 256, 128)
    # Inscribed with 128 segments around the tube: 1 - (64 / pi) sin(pi / 64) = 4e-4.
    assert volume(mesh) == pytest.approx(exact_volume, rel=1e-3)
    assert area(mesh) == pytest.approx(exact_area, rel=1e-3)


def test_arc_of_a_torus_starts_at_x_and_turns_to_y() -> None:
    low, high = shapes.torus(0.2, 90.0).bounds()
    assert high[0] == pytest.approx(1.2)
    assert high[1] == pytest.approx(1.2, abs=1e-3)
    assert low[0] == pytest.approx(0.0, abs=1e-12)
    assert low[1] == pytest.approx(0.0, abs=1e-12)


def test_bumpy_sphere_has_the_normals_of_its_surface() -> None:
    mesh = shapes.sphere(512, 0.2, 6.0)
    assert mesh.normals is not None
    corner = mesh.triangles[len(mesh.triangles) // 3]
    face = mesh.face_normals()[len(mesh.triangles) // 3]
    # Triangles of 0.7 degrees turn by under a degree from corner to corner.
    assert np.min(mesh.normals[corner] @ face) > np.cos(np.radians(2.0))
    radius = np.linalg.norm(mesh.positions, axis=1)
    assert radius.min() < 0.9
    assert radius.max() > 1.1


def test_without_bumps_a_sphere_is_exactly_the_plain_one() -> None:
    assert np.array_equal(shapes.sphere(32, 0.0, 5.0).positions, shapes.sphere(32).positions)
