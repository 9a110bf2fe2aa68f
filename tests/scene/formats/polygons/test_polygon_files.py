"""Polygon files as exporters write them: each opens, with its right area and colours."""

from __future__ import annotations

import struct
from collections.abc import Callable

import numpy as np
import pytest
from image_bytes import plain_png
from meshes import area
from scene.fixture_types import Write
from scene.formats.polygons.polygon_cases import (
    BLUE,
    CASES,
    ORANGE,
    SQUARE,
    Bytes,
    colored,
    faces,
    header,
    stl,
    text_stl,
    triangle,
)

from ssdo_gl.color import linear_from_srgb
from ssdo_gl.scene.formats import read_model
from ssdo_gl.scene.geometry.mesh import Mesh


def srgb_bytes(mesh: Mesh) -> set[Bytes]:
    if mesh.colors is None:
        return set()
    table = linear_from_srgb(np.arange(256) / 255.0)
    near = np.abs(mesh.colors[:, :3, None] - table).argmin(axis=2)
    return {(int(r), int(g), int(b)) for r, g, b in near}


@pytest.mark.parametrize("name", CASES)
def test_opens_with_its_area_and_colours(name: str, write: Write) -> None:
    case = CASES[name]
    meshes = read_model(write({f"a{case.suffix}": case.content}), "a").meshes
    assert sum(area(mesh) for mesh in meshes) == pytest.approx(case.area)
    assert set().union(*map(srgb_bytes, meshes)) == case.colors


def test_strips_keep_their_sides(write: Write) -> None:
    mesh = read_model(write({"a.ply": CASES["tristrips"].content}), "a").meshes[0]
    assert mesh.face_normals().tolist() == [[0, 0, 1]] * 3


def test_text_is_rounded_as_binary_is(write: Write) -> None:
    text = triangle("", "").replace(b"0 1 0", b"0 0.1 0")
    mesh = read_model(write({"a.ply": text}), "a").meshes[0]
    assert mesh.positions[2, 1] == np.float32(0.1)
    text = text.replace(b"float", b"double")
    assert read_model(write({"a.ply": text}), "a").meshes[0].positions[2, 1] == 0.1


@pytest.mark.parametrize("name", ["my wood.png", "<this>_wood.png"])
def test_a_texture_file_is_shown(write: Write, name: str) -> None:
    text = header(
        "ascii", 4, faces(1), "property float s\nproperty float t\n",
        f"comment TextureFile {name}\n",
    ) + "0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 0.75\n0 1 0 0 0.75\n4 0 1 2 3\n"  # fmt: skip
    model = read_model(write({name.replace("<this>", "a"): plain_png(ORANGE), "a.ply": text}), "a")
    texture = model.materials[0].albedo_texture
    assert texture is not None
    assert texture.pixels[0, 0].tolist() == [*ORANGE, 255]
    assert model.materials[0].albedo == (1.0, 1.0, 1.0)
    # v counts upward in the file and downward here.
    uvs = model.meshes[0].uvs
    assert uvs is not None
    assert uvs.tolist() == [[0, 1], [1, 1], [1, 0.25], [0, 0.25]]


@pytest.mark.parametrize("name", ["none.png", "../a.png", "a.ply"])
def test_a_missing_texture_is_told_and_colours_stay(name: str, write: Write) -> None:
    text = colored("uchar", "255 128 0").replace(
        b"element v", b"comment TextureFile " + name.encode() + b"\nelement v"
    )
    model = read_model(write({"a.ply": text}), "a")
    assert srgb_bytes(model.meshes[0]) == {ORANGE}
    assert any("texture not used" in note for note in model.notes)


def test_faces_choose_among_textures(write: Write) -> None:
    more = "property list uchar float texcoord\nproperty int texnumber\n"
    extra = "comment TextureFile a.png\ncomment TextureFile b.png\n"
    text = (
        header("ascii", 4, faces(2, more), extra=extra)
        + SQUARE
        + ("3 0 1 2 6 0 0 1 0 1 1 1\n3 0 2 3 6 0 0 1 1 0 1 0\n")
    )
    model = read_model(
        write({"a.png": plain_png(ORANGE), "b.png": plain_png(BLUE), "a.ply": text}), "a"
    )
    shown = [
        (material.albedo_texture.pixels[0, 0, :3].tolist(), model.meshes[item.mesh].positions[1, 0])
        for item in model.objects
        if (material := model.materials[item.material]).albedo_texture is not None
    ]
    assert shown == [([*ORANGE], 1.0), ([*BLUE], 1.0)]
    assert [len(mesh.triangles) for mesh in model.meshes] == [1, 1]


def test_signalling_nans_are_dropped_without_noise(write: Write) -> None:
    nan = struct.pack("<I", 0x7F800001)
    data = stl([0, 0])
    model = read_model(write({"a.stl": data[:96] + nan + data[100:]}), "a")
    assert area(model.meshes[0]) == 0.5
    assert any("NaN" in note for note in model.all_notes())


CORNERS = "0 0 0\n1 0 0\n0 1 0\n"


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.ply", header("ascii", 3, faces(1)) + "0 0 0\n1 0 0\n0 x 0\n3 0 1 2\n", "'x' stands"),
        ("a.ply", header("ascii", 3, faces(1)) + "0 0 0\n1 0 0\n", "ends before its 3 rows"),
        ("a.ply", header("ascii", 10**15, faces(1)), "ends before its"),
        ("a.ply", header("cuneiform", 3, faces(0)), "'cuneiform'"),
        ("a.ply", header("ascii", 3, "element face 1\nproperty list x y z\n"), "property list x"),
        ("a.ply", "ply\nformat ascii 1.0\n", "no end_header"),
        ("a.ply", triangle("", "", "3 0 1 9"), "vertex 9 of 3"),
        ("a.ply", triangle("", "", "3 0 1 nan"), "vertex -2 of 3"),
        (
            "a.ply",
            (
                header("binary_little_endian", 0, faces(0)).encode()[:-11]
                + b"element e 1\nproperty list uint float a\nend_header\n\xff\xff\xff\xff"
            ),
            "a list of 'e' has 4294967295 entries",
        ),
        # MeshLab's colours of corners are a list, of which its headers say nothing.
        ("a.ply", header("ascii", 3, faces(2)) + CORNERS + "3 0 1 2 .5\n" * 2, "has 0.5 e"),
        ("a.ply", header("ascii", 3, faces(2)) + CORNERS + "3 0 1 2 3 .5 .5 .5\n" * 2, "vertex -2"),
        ("a.off", "OFF\n4000000000 4000000000 0\n0 0 0\n", "ends before its"),
        ("a.off", "OFF\n3 1 0\n0 0 0\n1 0 x\n0 1 0\n3 0 1 2\n", "something else than numbers"),
        ("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -2\n", "'-2' stands"),
        ("a.off", "OFF BINARY\n", "ends before its vertices"),
        ("a.off", b"OFF BINARY\n" + struct.pack("<5i", 0, 2, 0, 9, 0), "its 2 faces"),
        ("a.off", "hello\n", "neither OFF nor"),
        ("a.stl", text_stl(b"a").replace(b"vertex 1 1 0\n", b""), "not three vertices"),
        ("a.stl", text_stl(b"a").replace(b"vertex 1 1 0", b"vertex 1 1 y"), "'y' stands"),
    ],
)
def test_what_is_damaged_gets_one_line(
    name: str, content: str | bytes, said: str, write: Write, error_of: Callable[..., str]
) -> None:
    assert said in error_of(write({name: content}))
