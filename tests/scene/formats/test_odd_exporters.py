"""Files as some exporters write them, which other viewers open."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from meshes import area

from ssdo_gl.scene.load import load_scene

CORNERS = [(0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 2.0)]
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
# Three right angles of legs 2, and the face across them.
AREA = 3 * 2.0 + np.sqrt(3.0) / 4.0 * 8.0


def area_of(path):
    return sum(area(mesh) for mesh in load_scene(path, ground="off").meshes)


@pytest.mark.parametrize("order", [">", "<"])
@pytest.mark.parametrize("colors", [None, 0, 3])
def test_binary_off(tmp_path, order, colors):
    data = b"OFF BINARY\n" + struct.pack(f"{order}3i", 4, 4, 6)
    data += b"".join(struct.pack(f"{order}3f", *corner) for corner in CORNERS)
    for face in FACES:
        data += struct.pack(f"{order}4i", 3, *face)
        if colors is not None:
            data += struct.pack(f"{order}i{colors}f", colors, *[0.5] * colors)
    path = tmp_path / "a.off"
    path.write_bytes(data)
    assert area_of(path) == pytest.approx(AREA)


def test_binary_off_with_normals(tmp_path):
    data = b"NOFF BINARY\n" + struct.pack(">3i", 4, 4, 6)
    data += b"".join(struct.pack(">6f", *corner, 0, 0, 1) for corner in CORNERS)
    data += b"".join(struct.pack(">5i", 3, *face, 0) for face in FACES)
    path = tmp_path / "a.off"
    path.write_bytes(data)
    assert area_of(path) == pytest.approx(AREA)


def test_off_whose_count_follows_its_keyword_at_once(tmp_path):
    path = tmp_path / "a.off"
    rows = "".join(f"{x} {y} {z}\n" for x, y, z in CORNERS)
    path.write_text(
        f"  OFF4 4 6 # or so\n{rows}" + "".join(f"3 {a} {b} {c}\n" for a, b, c in FACES)
    )
    assert area_of(path) == pytest.approx(AREA)


def test_binary_ply_whose_header_ends_otherwise_than_it_begins(tmp_path):
    header = (
        "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\n"
        "property float y\nproperty float z\nelement face 4\n"
        "property list uchar int vertex_indices\nend_header\r\n"
    )
    data = header.encode() + b"".join(struct.pack("<3f", *corner) for corner in CORNERS)
    path = tmp_path / "a.ply"
    path.write_bytes(data + b"".join(struct.pack("<B3i", 3, *face) for face in FACES))
    assert area_of(path) == pytest.approx(AREA)


def test_ply_with_a_comment_that_lacks_its_first_word(tmp_path):
    rows = "".join(f"{x} {y} {z}\n" for x, y, z in CORNERS)
    rows += "".join(f"3 {a} {b} {c}\n" for a, b, c in FACES)
    path = tmp_path / "a.ply"
    path.write_text(
        "ply\nformat ascii 1.0\nCreated by a modeller, source file: \nelement vertex 4\n"
        "property float x\nproperty float y\nproperty float z\nelement face 4\n"
        f"property list uchar uint vertex_indices\nend_header\n{rows}"
    )
    assert area_of(path) == pytest.approx(AREA)


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be", "utf-8"])
def test_obj_in_any_unicode(tmp_path, encoding):
    text = "\ufeff" + "".join(f"v {x} {y} {z}\r\n" for x, y, z in CORNERS)
    text += "".join(f"f {a + 1} {b + 1} {c + 1}\r\n" for a, b, c in FACES)
    path = tmp_path / "a.obj"
    path.write_bytes(text.encode(encoding))
    assert area_of(path) == pytest.approx(AREA)


@pytest.mark.parametrize(("count", "drawn"), [(0, 4), (2, 2), (4, 4), (9, 4)])
def test_binary_stl_with_a_wrong_count_says_so(tmp_path, count, drawn):
    data = bytes(80) + struct.pack("<I", count)
    for face in FACES:
        corners = [number for corner in face for number in CORNERS[corner]]
        data += struct.pack("<12fH", 0, 0, 0, *corners, 0)
    path = tmp_path / "a.stl"
    path.write_bytes(data)
    scene = load_scene(path, ground="off")
    assert scene.triangle_count == drawn
    named = f"the file says it has {count} facets and holds 4: {drawn} are drawn"
    assert (named in scene.notes) == (count != 4)


def test_ply_whose_header_is_indented(tmp_path):
    header = (
        "ply\n\t comment x \n  format  binary_little_endian \t1.0  \n\n element  vertex 4\n"
        "\tproperty float \t x\n  property float y \nproperty\tfloat z\n  element face\t4\n"
        " property   list uchar  int vertex_indices\t\n \t end_header \t\n"
    )
    data = header.encode() + b"".join(struct.pack("<3f", *corner) for corner in CORNERS)
    data += b"".join(struct.pack("<B3i", 3, *face) for face in FACES)
    path = tmp_path / "a.ply"
    path.write_bytes(data)
    assert area_of(path) == pytest.approx(AREA)
