"""Wavefront .obj files with their materials."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from image_bytes import png
from scene.fixture_types import Write

from ssdo_gl.color import linear_from_srgb
from ssdo_gl.scene.lights import RectangleLight
from ssdo_gl.scene.load import load_scene

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def test_polygons_become_triangles(write: Write) -> None:
    scene = load_scene(write({"a.obj": SQUARE + "f 1 2 3 4\n"}))
    mesh = scene.meshes[0]
    assert mesh.positions[mesh.triangles].tolist() == [
        [[0, 0, 0], [1, 0, 0], [1, 1, 0]],
        [[0, 0, 0], [1, 1, 0], [0, 1, 0]],
    ]
    assert mesh.normals is None
    assert mesh.uvs is None


def test_negative_indices_count_from_their_line(write: Write) -> None:
    text = SQUARE + "f -4 -3 -2\n" + "v 5 5 5\nv 6 5 5\nv 6 6 5\n" + "f -3 -2 -1\n"
    mesh = load_scene(write({"a.obj": text})).meshes[0]
    assert mesh.positions[mesh.triangles[0]].tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0]]
    assert mesh.positions[mesh.triangles[1]].tolist() == [[5, 5, 5], [6, 5, 5], [6, 6, 5]]


def test_tabs_comments_and_continued_lines(write: Write) -> None:
    text = "v\t0 0 0 # first\nv 1 \\\n 0 0\n\nv 0\t1\t0\nf 1 \\\n2 3\n"
    assert load_scene(write({"a.obj": text.replace("\n", "\r\n")})).triangle_count == 1


def test_a_comment_that_ends_with_a_backslash_takes_no_vertex_with_it(write: Write) -> None:
    text = "# from C:\\models\\\n" + SQUARE + "f 1 2 3 4\n"
    assert len(load_scene(write({"a.obj": text})).meshes[0].positions) == 4


def test_normals_and_coordinates(write: Write) -> None:
    text = SQUARE + "vn 0 0 3\nvt 0 0\nvt 0.5 0.25 0\nvt 1\nf 1/1/1 2/2/1 3/3/1\n"
    mesh = load_scene(write({"a.obj": text})).meshes[0]
    assert mesh.normals is not None
    assert mesh.normals.tolist() == [[0, 0, 1]] * 3
    # v counts upward in the file and downward here.
    assert mesh.uvs is not None
    assert mesh.uvs.tolist() == [[0, 1], [0.5, 0.75], [1, 1]]


def test_faces_without_normals_are_flat_among_others(write: Write) -> None:
    text = SQUARE + "v 0 0 1\nvn 0 1 0\nvn 0 1 0\nf 1//1 2//1 3//2\nf 1 4 5\nf 1//1 4//9 5//1\n"
    mesh = load_scene(write({"a.obj": text})).meshes[0]
    assert mesh.normals is not None
    flat = [[1, 0, 0]] * 3
    assert mesh.normals[mesh.triangles].tolist() == [[[0, 1, 0]] * 3, flat, flat]


def test_materials_keep_their_factors(write: Write) -> None:
    obj = "mtllib m.mtl\n" + SQUARE + "usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\nusemtl a\nf 2 3 4\n"
    mtl = "newmtl a\nKd 0.123456 0.2 0.3\nKs 0 0 0\n# note\nnewmtl b\nKd 1 1 1\nKs 0.5 0 0\nd 0.5\n"
    scene = load_scene(write({"m.mtl": mtl, "a.obj": obj}))
    assert [material.albedo for material in scene.materials] == [(0.123456, 0.2, 0.3), (1, 1, 1)]
    assert [len(scene.meshes[item.mesh].triangles) for item in scene.objects] == [2, 1]
    assert [material.alpha for material in scene.materials] == [1.0, 0.5]


@pytest.mark.parametrize("line", ["Kd 1 0", "Kd a b c", "Kd -1 0 0", "Ke nan 0 0"])
def test_a_bad_colour_is_refused(line: str, write: Write, error_of: Callable[..., str]) -> None:
    obj = "mtllib m.mtl\n" + SQUARE + "usemtl a\nf 1 2 3\n"
    message = error_of(write({"m.mtl": f"newmtl a\n{line}\n", "a.obj": obj}))
    assert "m.mtl" in message
    assert line.split()[0] in message


@pytest.mark.parametrize("name", ["none.mtl", "../m.mtl", "/etc/passwd"])
def test_a_missing_library_is_told(name: str, write: Write) -> None:
    obj = f"mtllib {name}\n{SQUARE}usemtl a\nf 1 2 3\n"
    scene = load_scene(write({"m.mtl": "newmtl a\nKd 1 0 0\n", "sub/a.obj": obj}))
    assert scene.materials[0].albedo == (0.8, 0.8, 0.8)
    assert any("materials not read" in note for note in scene.notes)
    assert any("drawn grey" in note for note in scene.notes)


def test_many_materials_that_no_library_defines_are_one_line(write: Write) -> None:
    faces = "".join(f"usemtl m{i}\nf 1 2 3\n" for i in range(40))
    scene = load_scene(write({"a.obj": SQUARE + faces}))
    (note,) = [note for note in scene.notes if "drawn grey" in note]
    assert note == "no material library defines 'm0', 'm1', 'm2' and 37 more: drawn grey"


def test_textures_and_masks(write: Write) -> None:
    color = np.full((2, 2, 3), (200, 100, 50), dtype=np.uint8)
    mask = np.array([[0, 255], [255, 0]], dtype=np.uint8)
    obj = "mtllib m.mtl\n" + SQUARE + "vt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n"
    mtl = "newmtl a\nKd 0 0 0\nmap_Kd -s 1 1 1 -clamp on my color.png\nmap_d mask.png\n"
    scene = load_scene(
        write({"my color.png": png(color), "mask.png": png(mask), "m.mtl": mtl, "a.obj": obj})
    )
    (material,) = scene.materials[:1]
    assert material.albedo == (1.0, 1.0, 1.0)  # zero would hide the texture
    texture = material.albedo_texture
    assert texture is not None
    assert texture.wrap == ("clamp", "clamp")
    assert texture.pixels[..., :3].tolist() == color.tolist()
    assert texture.pixels[..., 3].tolist() == mask.tolist()
    assert material.alpha_cutoff == 0.5


def test_a_missing_texture_is_told(write: Write) -> None:
    obj = "mtllib m.mtl\n" + SQUARE + "usemtl a\nf 1 2 3\n"
    mtl = "newmtl a\nKd 1 0 0\nmap_Kd C:\\textures\\wood.png\n"
    scene = load_scene(write({"m.mtl": mtl, "a.obj": obj}))
    assert scene.materials[0].albedo == (1.0, 0.0, 0.0)
    assert any("texture not used" in note for note in scene.notes)


def test_vertex_colours_are_decoded(write: Write) -> None:
    text = "v 0 0 0 1 0 0.5\nv 1 0 0 1 0 0.5\nv 0 1 0 1 0 0.5\nf 1 2 3\n"
    scene = load_scene(write({"a.obj": text}))
    colors = scene.meshes[0].colors
    assert colors is not None
    middle = float(linear_from_srgb(np.array(0.5)))
    assert colors[0] == pytest.approx([1.0, 0.0, middle, 1.0])
    assert scene.materials[0].albedo == (1.0, 1.0, 1.0)


ROOM = (
    "mtllib m.mtl\n"
    "v 0 0 0\nv 4 0 0\nv 4 0 4\nv 0 0 4\n"  # floor
    "v 1 3 1\nv 2 3 1\nv 2 3 2\nv 1 3 2\n"  # lamp
    "usemtl floor\nf 4 3 2 1\nusemtl lamp\n"
)
LAMP = "newmtl floor\nKd 0.5 0.5 0.5\nnewmtl lamp\nKd 0.7 0.7 0.7\nKe 17 12 4\n"


@pytest.mark.parametrize("face", ["f 5 6 7 8\n", "f 5 8 7 6\n"])
def test_an_emissive_quad_is_a_light_that_faces_the_scene(face: str, write: Write) -> None:
    scene = load_scene(write({"m.mtl": LAMP, "a.obj": ROOM + face}))
    (light,) = scene.lights
    assert isinstance(light, RectangleLight)
    assert light.radiance == (17.0, 12.0, 4.0)
    normal = np.cross(light.edge_u, light.edge_v)
    assert normal.tolist() == [0.0, -1.0, 0.0]
    (body,) = [item for item in scene.objects if item.light == 0]
    assert scene.meshes[body.mesh].face_normals()[0].tolist() == [0.0, -1.0, 0.0]
    turned = [note for note in scene.notes if "turned around" in note]
    assert len(turned) == (0 if face == "f 5 6 7 8\n" else 1)
    assert scene.environment is None
