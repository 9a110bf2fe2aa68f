"""Whatever is wrong with a model is said in one line that names its file."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from scene.fixture_types import ErrorOf, Write

from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene_error import SceneError

OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


@pytest.mark.parametrize(
    ("name", "content", "parts"),
    [
        ("a.glb", b"", ["does not start with 'glTF'"]),
        ("a.glb", b"glTF\x02\0\0\0", ["truncated GLB"]),
        ("a.glb", struct.pack("<III", 0x46546C67, 2, 500) + bytes(20), ["truncated", "500", "32"]),
        ("a.glb", struct.pack("<III", 0x46546C67, 1, 20) + bytes(8), ["version 1"]),
        ("a.glb", struct.pack("<IIIII", 0x46546C67, 2, 20, 99, 0x4E4F534A), ["chunk"]),
        ("a.glb", struct.pack("<IIIII", 0x46546C67, 2, 20, 0, 0x1234), ["no JSON chunk"]),
        ("a.gltf", b"{", ["line 1, column 2"]),
        ("a.gltf", b"\xff\xfe", ["not UTF-8"]),
        ("a.gltf", b"[]", ["no 'asset'"]),
        ("a.gltf", b"{}", ["no 'asset'"]),
        ("a.gltf", b'{"asset": {"version": "1.0"}}', ["version '1.0'"]),
        ("a.gltf", b'{"asset": {"version": "2.0"}}', ["no triangle"]),
        ("a.gltf", b'{"asset": {"version": "2.0"}, "nodes": 3}', ["not valid glTF"]),
        ("a.gltf", b'{"asset": {"version": "2.0"}, "nodes": [{"mesh": 7}]}', ["meshes 7, but"]),
        (
            "a.gltf",
            (
                b'{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],'
                b' "nodes": [{"children": [0]}]}'
            ),
            ["node 0 has two parents, or is within itself"],
        ),
        (
            "a.gltf",
            b'{"asset": {"version": "2.0"}, "extensionsRequired": ["KHR_implicit_shapes"]}',
            ["KHR_implicit_shapes", "not supported"],
        ),
        ("a.obj", b"", ["no triangle"]),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nl 1 2\n", ["no triangle", "only 1 line"]),
        ("a.obj", b"v 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", ["'v 0 0'", "3 numbers"]),
        ("a.obj", b"v a b c\nf 1 1 1\n", ["'v a b c'"]),
        ("a.obj", OBJ.encode() + b"f 1 2 9\n", ["v 9", "there are 3"]),
        ("a.obj", OBJ.encode() + b"f 1 2 -9\n", ["-"]),
        ("a.obj", OBJ.encode() + b"f x y z\n", ["'x'", "1/2/3"]),
        ("a.obj", OBJ.encode() + b"f 0 1 2\n", ["v 0"]),
        ("a.obj", b"v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n", ["no triangle with an area"]),
        ("a.obj", b"v nan 0 0\nv 1 1 1\nv 2 5 2\nf 1 2 3\n", ["no triangle with an area"]),
        (
            "a.obj",
            b"v 1.#IND -1.#QNAN 0\nv 1 1 1\nv 2 5 2\nf 1 2 3\n",
            ["no triangle with an area"],
        ),
        ("a.obj", bytes(range(256)) * 8, ["no triangle"]),
        ("a.ply", b"", ["not a readable PLY"]),
        ("a.ply", b"ply\nformat ascii 1.0\nend_header\n", ["a.ply"]),
        ("a.ply", bytes(range(256)), ["not a readable PLY"]),
        ("a.stl", b"", ["a.stl"]),
        ("a.stl", b"solid x\nendsolid x\n", ["a.stl"]),
        ("a.stl", bytes(80) + struct.pack("<I", 1000), ["a.stl"]),
        ("a.off", b"", ["not a readable OFF"]),
        ("a.off", b"OFF\n0 0 0\n", ["no triangle with an area"]),
        ("a.off", b"OFF\n3 1 0\n0 0 0\n", ["not a readable OFF"]),
        ("a.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", ["not a readable OFF"]),
        ("a.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n", ["no triangle with an area"]),
        ("a.off", b"OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 1 0\n", ["before its 2 faces"]),
    ],
)
def test_a_bad_model_is_refused_in_one_line(
    name: str, content: bytes, parts: list[str], write: Write, error_of: ErrorOf
) -> None:
    message = error_of(write({name: content}))
    assert message.count(name) == 1
    for part in parts:
        assert part in message


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.obj", "mtllib a.mtl\nusemtl red\n" + OBJ),
        ("a.obj", "v 0,5 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("a.off", "OFF\n3 1 0\n0,5 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
        (
            "a.ply",
            (
                "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                "property float z\nend_header\n0,5 0 0\n"
            ),
        ),
        ("a.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0,5 0 0\nvertex 1 0 0\n"),
    ],
)
def test_decimal_commas_are_named(name: str, content: str, write: Write, error_of: ErrorOf) -> None:
    message = error_of(write({"a.mtl": "newmtl red\nKd 0,5 0 0\n", name: content}))
    assert message.endswith("decimals take a point, not a comma")


def test_truncation_anywhere_is_one_line(write: Write, glb, tmp_path: Path) -> None:
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    whole = glb.bytes()
    path = tmp_path / "cut.glb"
    for length in range(0, len(whole) - 1, 7):
        path.write_bytes(whole[:length])
        with pytest.raises(SceneError) as caught:
            load_scene(path)
        assert "\n" not in str(caught.value)


def test_damage_anywhere_is_a_scene_or_one_line(glb, tmp_path: Path) -> None:
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    whole = glb.bytes()
    random = np.random.default_rng(5)
    path = tmp_path / "damaged.glb"
    for _ in range(300):
        data = bytearray(whole)
        data[random.integers(20, len(data))] = random.integers(256)
        path.write_bytes(data)
        try:
            load_scene(path)
        except SceneError as error:
            assert "\n" not in str(error)
