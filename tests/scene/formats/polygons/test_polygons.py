"""Single meshes: .ply, .stl and .off."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from scene.fixture_types import Write

from ssdo_gl.color import linear_from_srgb
from ssdo_gl.scene.load import load_scene


def ply(properties: str, rows: list[str], faces: list[str], face_properties: str = "") -> str:
    return (
        f"ply\nformat ascii 1.0\nelement vertex {len(rows)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"{properties}element face {len(faces)}\n"
        f"property list uchar int vertex_indices\n{face_properties}end_header\n"
        + "\n".join([*rows, *faces])
        + "\n"
    )


TRIANGLE = ["0 0 0", "1 0 0", "0 1 0"]


def test_ply_without_normals_is_flat(write: Write) -> None:
    scene = load_scene(write({"a.ply": ply("", TRIANGLE, ["3 0 1 2"])}))
    assert scene.meshes[0].normals is None
    assert scene.meshes[0].positions.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert scene.materials[0].albedo == (0.8, 0.8, 0.8)


def test_ply_normals_are_kept(write: Write) -> None:
    rows = [f"{row} 0 0 1" for row in TRIANGLE]
    properties = "property float nx\nproperty float ny\nproperty float nz\n"
    scene = load_scene(write({"a.ply": ply(properties, rows, ["3 0 1 2"])}))
    assert scene.meshes[0].normals.tolist() == [[0, 0, 1]] * 3


def test_ply_bytes_are_srgb(write: Write) -> None:
    rows = [f"{row} 255 0 128" for row in TRIANGLE]
    properties = "property uchar red\nproperty uchar green\nproperty uchar blue\n"
    scene = load_scene(write({"a.ply": ply(properties, rows, ["3 0 1 2"])}))
    middle = float(linear_from_srgb(np.array(128 / 255)))
    assert scene.meshes[0].colors[0] == pytest.approx([1.0, 0.0, middle, 1.0])
    assert scene.materials[0].albedo == (1.0, 1.0, 1.0)


def test_ply_quads_are_split(write: Write) -> None:
    rows = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"]
    scene = load_scene(write({"a.ply": ply("", rows, ["4 0 1 2 3"])}))
    assert scene.triangle_count == 2


def test_ply_drops_what_cannot_be_drawn(write: Write) -> None:
    rows = [*TRIANGLE, "nan 0 0"]
    scene = load_scene(write({"a.ply": ply("", rows, ["3 0 1 2", "3 0 1 3", "3 0 0 1"])}))
    assert scene.triangle_count == 1
    assert any("NaN" in note for note in scene.notes)
    assert any("without area" in note for note in scene.notes)


def binary_stl(corners: np.ndarray) -> bytes:
    data = bytes(80) + struct.pack("<I", len(corners))
    for triangle in corners:
        data += np.concatenate([np.zeros(3), triangle.reshape(-1)]).astype("<f4").tobytes()
        data += b"\0\0"
    return data


def tetrahedron() -> np.ndarray:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    return points[np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])]


def test_binary_stl_is_closed_by_equal_positions(write: Write) -> None:
    scene = load_scene(write({"a.stl": binary_stl(tetrahedron())}))
    assert scene.triangle_count == 4
    assert scene.meshes[0].closed
    assert scene.meshes[0].normals is None
    assert not load_scene(write({"b.stl": binary_stl(tetrahedron()[:3])})).meshes[0].closed


def test_ascii_stl(write: Write) -> None:
    text = "solid part\n"
    for triangle in tetrahedron():
        text += "facet normal 0 0 0\nouter loop\n"
        text += "".join(f"vertex {x} {y} {z}\n" for x, y, z in triangle)
        text += "endloop\nendfacet\n"
    scene = load_scene(write({"a.stl": text + "endsolid part\n"}))
    assert scene.triangle_count == 4
    assert scene.meshes[0].closed


def test_off_and_suffixes_in_capitals(write: Write) -> None:
    text = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n"
    scene = load_scene(write({"A.OFF": text}))
    assert scene.triangle_count == 2
    assert scene.bounds()[1].tolist() == [1.0, 1.0, 0.0]


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_models_of_any_size_are_framed(scale: float, write: Write) -> None:
    scene = load_scene(write({"a.stl": binary_stl(tetrahedron() * scale)}))
    distance = np.linalg.norm(np.subtract(scene.camera.position, scene.camera.target))
    assert 0.5 * scale < distance < 10.0 * scale
