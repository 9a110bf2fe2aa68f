"""Points are drawn as small bodies; lines are named."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.scene.formats import point_bodies
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene_error import SceneError

CUBE = [(x, y, z) for x in (0, 2) for y in (0, 2) for z in (0, 2)]
# The diagonal is sqrt 12; of eight points a body's radius is a hundredth of it.
RADIUS = 0.01 * np.sqrt(12.0)


def ply(rows, properties="", faces=""):
    count = f"element face {faces.count(chr(10))}\nproperty list uchar int vertex_indices\n"
    return (
        f"ply\nformat ascii 1.0\nelement vertex {len(rows)}\n"
        f"property float x\nproperty float y\nproperty float z\n{properties}"
        f"{count if faces else ''}end_header\n"
        + "".join(" ".join(map(str, row)) + "\n" for row in rows)
        + faces
    )


def loaded(tmp_path, name, text):
    path = tmp_path / name
    path.write_text(text)
    return load_scene(path, ground="off")


def centers(mesh):
    return mesh.positions.reshape(-1, 6, 3).mean(axis=1)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
def test_points_of_a_ply_file(tmp_path, scale):
    rows = [tuple(scale * c for c in point) for point in CUBE]
    scene = loaded(tmp_path, "cloud.ply", ply(rows))
    assert scene.triangle_count == 8 * 8
    assert any("8 points drawn" in note for note in scene.notes)
    low, high = scene.bounds()
    assert low == pytest.approx([-RADIUS * scale] * 3)
    assert high == pytest.approx([(2 + RADIUS) * scale] * 3)
    assert scene.meshes[0].closed


def test_colours_of_points(tmp_path):
    properties = "".join(f"property uchar {c}\n" for c in ("red", "green", "blue"))
    scene = loaded(tmp_path, "cloud.ply", ply([(*p, 255, 0, 0) for p in CUBE], properties))
    assert np.all(scene.meshes[0].colors[:, :3] == [1.0, 0.0, 0.0])


def test_vertices_without_a_face_are_no_points_of_a_mesh(tmp_path):
    scene = loaded(tmp_path, "mesh.ply", ply([*CUBE, (9, 9, 9)], faces="3 0 1 2\n"))
    assert scene.triangle_count == 1 and not any("points" in note for note in scene.notes)


def test_points_and_faces_of_an_obj_file_are_both_drawn(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5 1 0 0\nf 1 2 3\np 4 -2\nl 1 2\n"
    scene = loaded(tmp_path, "both.obj", text)
    assert scene.triangle_count == 1 + 2 * 8
    bodies = next(m for m in scene.meshes if len(m.triangles) == 16)
    assert sorted(map(tuple, np.round(centers(bodies), 9))) == [(0, 1, 0), (5, 5, 5)]
    assert any("1 line" in note for note in scene.notes)


def test_points_may_have_texture_coordinates_and_normals_as_corners_have(tmp_path):
    text = "v 0 0 0\nv 4 0 0\nvt 0 0\nvn 0 0 1\np 1//1 2/1/1\np -1/-1\n"
    scene = loaded(tmp_path, "points.obj", text)
    (bodies,) = scene.meshes
    assert sorted(map(tuple, np.round(centers(bodies), 9))) == [(0, 0, 0), (4, 0, 0), (4, 0, 0)]


def test_an_obj_file_of_vertices_alone_is_a_cloud(tmp_path):
    text = "".join(f"v {x} {y} {z}\n" for x, y, z in CUBE)
    assert loaded(tmp_path, "cloud.obj", text).triangle_count == 8 * 8


@pytest.mark.parametrize("word", ["9", "0", "-5", "x", "99999999999999999999"])
def test_points_that_do_not_exist_are_named(tmp_path, word):
    with pytest.raises(SceneError, match=r"bad\.obj"):
        loaded(tmp_path, "bad.obj", f"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\np {word}\n")


def test_lines_alone_are_named(tmp_path):
    with pytest.raises(SceneError, match="only 1 line"):
        loaded(tmp_path, "lines.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n")


def test_points_of_gltf_beside_triangles(glb, tmp_path):
    place = glb.accessor(np.array(CUBE, "<f4"), "VEC3")
    color = glb.accessor(np.tile([0.0, 0.5, 1.0], (8, 1)).astype("<f4"), "VEC3")
    cloud = {"mode": 0, "attributes": {"POSITION": place, "COLOR_0": color}}
    glb.json["meshes"] = [{"primitives": [glb.triangle(), cloud]}]
    glb.json["nodes"] = [{"mesh": 0}]
    glb.json["scenes"] = [{"nodes": [0]}]
    scene = load_scene(glb.save(tmp_path / "both.glb"), ground="off")
    assert scene.triangle_count == 1 + 8 * 8
    bodies = next(m for m in scene.meshes if len(m.triangles) == 64)
    np.testing.assert_allclose(centers(bodies), CUBE, atol=1e-6)
    np.testing.assert_allclose(bodies.colors[:, :3], np.tile([0, 0.5, 1], (48, 1)))


def test_of_very_many_points_an_even_share_is_drawn(tmp_path, monkeypatch):
    monkeypatch.setattr(point_bodies, "MAX_POINTS", 10)
    rows = [(i, 0, 0) for i in range(25)]
    scene = loaded(tmp_path, "cloud.ply", ply(rows))
    assert scene.triangle_count == 9 * 8
    assert any("25 points drawn as small bodies, 9 of them" in note for note in scene.notes)


def test_points_that_are_nowhere_are_left_out(tmp_path):
    scene = loaded(tmp_path, "cloud.ply", ply([*CUBE, ("nan", 0, 0), ("inf", 0, 0)]))
    assert scene.triangle_count == 8 * 8


def test_a_single_point_has_a_size(tmp_path):
    low, high = loaded(tmp_path, "one.ply", ply([(1, 2, 3)])).bounds()
    assert 0.5 * (low + high) == pytest.approx([1, 2, 3])
    assert np.all(high > low)


def test_points_too_far_apart_for_a_size_are_refused_in_one_line(tmp_path, recwarn):
    with pytest.raises(SceneError, match=r"far\.obj"):
        loaded(tmp_path, "far.obj", "v 1e308 0 0\nv -1e308 0 1e308\nv 0 1e308 0\n")
    assert not len(recwarn)
