"""glTF accessors of every component type, as KHR_mesh_quantization and others allow them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from glb_writer import GlbWriter
from numpy.typing import NDArray

from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene

INTEGERS = ("|i1", "|u1", "<i2", "<u2")
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]])


def load(glb: GlbWriter, folder: Path, **attributes: int) -> Scene:
    glb.json["meshes"] = [{"primitives": [{**glb.triangle(), "material": 0}]}]
    glb.json["meshes"][0]["primitives"][0]["attributes"] |= attributes
    glb.json["materials"] = [{"pbrMetallicRoughness": {"metallicFactor": 0}}]
    return load_scene(glb.save(folder / "a.glb"), ground="off")


def padded(values: NDArray[Any], glb: GlbWriter, kind: str, **more: Any) -> int:
    """Return an accessor whose elements are aligned to four bytes."""
    size = values.itemsize * values.shape[1]
    stride = -(-size // 4) * 4
    rows = np.zeros((len(values), stride), np.uint8)
    rows[:, :size] = np.ascontiguousarray(values).view(np.uint8).reshape(len(values), size)
    index = glb.accessor(values, kind, **more)
    view = glb.view(rows.tobytes())
    glb.json["bufferViews"][view]["byteStride"] = stride
    glb.json["accessors"][index]["bufferView"] = view
    return index


@pytest.mark.parametrize("dtype", INTEGERS)
@pytest.mark.parametrize("normalized", [False, True])
def test_quantized_positions(dtype: str, normalized: bool, glb: GlbWriter, tmp_path: Path) -> None:
    full = np.iinfo(dtype).max
    index = padded((CORNERS * full).astype(dtype), glb, "VEC3", normalized=normalized)
    scene = load(glb, tmp_path, POSITION=index)
    (mesh,) = scene.meshes
    assert (
        mesh.positions[mesh.triangles[0]].tolist()
        == (CORNERS * (1 if normalized else full)).tolist()
    )


@pytest.mark.parametrize("dtype", ["|i1", "<i2"])
def test_quantized_normals(dtype: str, glb: GlbWriter, tmp_path: Path) -> None:
    low = np.iinfo(dtype).min
    normals = np.array([[0, 0, low]] * 3, dtype=dtype)
    scene = load(glb, tmp_path, NORMAL=padded(normals, glb, "VEC3", normalized=True))
    assert scene.meshes[0].normals is not None
    # The most negative number stands for -1 like the one above it.
    assert scene.meshes[0].normals.tolist() == [[0, 0, -1]] * 3


@pytest.mark.parametrize("dtype", INTEGERS)
@pytest.mark.parametrize("normalized", [False, True])
def test_quantized_coordinates(
    dtype: str, normalized: bool, glb: GlbWriter, tmp_path: Path
) -> None:
    full = np.iinfo(dtype).max
    uvs = np.array([[0, 0], [full, 0], [0, full]], dtype=dtype)
    index = padded(uvs, glb, "VEC2", normalized=normalized)
    scene = load(glb, tmp_path, TEXCOORD_0=index)
    assert scene.meshes[0].uvs is not None
    assert scene.meshes[0].uvs.max() == (1 if normalized else full)


@pytest.mark.parametrize("dtype", ["|u1", "<u2", "<f4"])
@pytest.mark.parametrize("kind", ["VEC3", "VEC4"])
def test_vertex_colours(dtype: str, kind: str, glb: GlbWriter, tmp_path: Path) -> None:
    full = 1.0 if dtype == "<f4" else float(np.iinfo(dtype).max)
    wanted = np.array([[1.0, 0.2, 0.0, 0.6]] * 3)[:, : 3 if kind == "VEC3" else 4]
    colors = np.rint(wanted * full) if full > 1 else wanted
    index = padded(colors.astype(dtype), glb, kind, normalized=dtype != "<f4")
    found = load(glb, tmp_path, COLOR_0=index).meshes[0].colors
    assert found is not None
    assert found[0] == pytest.approx([1.0, 0.2, 0.0, 1.0 if kind == "VEC3" else 0.6], abs=1e-7)


@pytest.mark.parametrize("dtype", ["|i1", "<i2", "<f4"])
def test_instances_with_quantized_rotations(dtype: str, glb: GlbWriter, tmp_path: Path) -> None:
    full = 1.0 if dtype == "<f4" else float(np.iinfo(dtype).max)
    turns = (np.array([[0, 0, 0, 1], [0, 0, 1, 0]]) * full).astype(dtype)
    moves = np.array([[0, 0, 0], [5, 0, 0]], dtype="<f4")
    attributes = {
        "ROTATION": glb.accessor(turns, "VEC4", normalized=dtype != "<f4"),
        "TRANSLATION": glb.accessor(moves, "VEC3"),
        "SCALE": glb.accessor(np.array([[1, 1, 1], [2, 2, 2]], dtype="<f4"), "VEC3"),
        "_ID": glb.accessor(np.array([7, 8], dtype="<u2"), "SCALAR"),
    }
    glb.json["nodes"][0]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
    scene = load(glb, tmp_path)
    (item,) = scene.objects
    ends = item.world_from_object @ [1, 0, 0, 1]
    assert ends[:, :3] == pytest.approx(np.array([[1, 0, 0], [3, 0, 0]]), abs=1e-12)


@pytest.mark.parametrize("dtype", ["|u1", "<u2"])
@pytest.mark.parametrize("weight", ["|u1", "<u2", "<f4"])
def test_joints_and_weights(dtype: str, weight: str, glb: GlbWriter, tmp_path: Path) -> None:
    joints = np.array([[0, 1, 0, 0]] * 3, dtype=dtype)
    full = 1.0 if weight == "<f4" else float(np.iinfo(weight).max)
    weights = (np.array([[0.0, 1.0, 0, 0]] * 3) * full).astype(weight)
    glb.json["nodes"] = [{"mesh": 0, "skin": 0}, {}, {"translation": [0, 0, 3]}]
    glb.json["scenes"] = [{"nodes": [0, 1, 2]}]
    glb.json["skins"] = [{"joints": [1, 2]}]
    scene = load(
        glb,
        tmp_path,
        JOINTS_0=padded(joints, glb, "VEC4"),
        WEIGHTS_0=padded(weights, glb, "VEC4", normalized=weight != "<f4"),
    )
    assert scene.bounds()[0].tolist() == [0.0, 0.0, 3.0]


@pytest.mark.parametrize("dtype", ["|i1", "<i2"])
def test_quantized_morph_targets(dtype: str, glb: GlbWriter, tmp_path: Path) -> None:
    full = np.iinfo(dtype).max
    lift = padded(np.array([[0, 0, full]] * 3, dtype=dtype), glb, "VEC3", normalized=True)
    primitive = {**glb.triangle(), "targets": [{"POSITION": lift}]}
    glb.json["meshes"] = [{"primitives": [primitive], "weights": [0.5]}]
    scene = load_scene(glb.save(tmp_path / "a.glb"), ground="off")
    assert scene.bounds()[1][2] == 0.5
