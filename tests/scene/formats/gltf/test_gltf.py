"""glTF: what the file says arrives exactly."""

from __future__ import annotations

import base64
import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from glb_writer import load
from image_bytes import plain_png
from scene.fixture_types import Write

from ssdo_gl.math3d import transform_points
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene_error import SceneError


def material_of(glb, tmp_path: Path, **material: object):
    """Return the imported form of one material on one triangle."""
    glb.json["materials"] = [material]
    glb.json["meshes"] = [{"primitives": [{**glb.triangle(), "material": 0}]}]
    scene = load(glb, tmp_path)
    return scene, scene.materials[scene.objects[0].material]


def test_colour_factors_are_exact(glb, tmp_path: Path) -> None:
    # 8 bits would make 0.2 into 51 / 255 = 0.2 and 0.123456 into 0.1215.
    _, material = material_of(
        glb,
        tmp_path,
        pbrMetallicRoughness={
            "baseColorFactor": [0.123456, 0.2, 0.3, 0.75],
            "metallicFactor": 0,
        },
        emissiveFactor=[0.0, 0.25, 1.0],
        extensions={"KHR_materials_emissive_strength": {"emissiveStrength": 8}},
        alphaMode="MASK",
        alphaCutoff=0.3,
        doubleSided=True,
    )
    assert material.albedo == (0.123456, 0.2, 0.3)
    assert material.alpha == 0.75
    assert material.emission == (0.0, 2.0, 8.0)
    assert material.alpha_cutoff == 0.3
    assert material.two_sided_emission


def test_the_default_material_is_white_and_dull(glb, tmp_path: Path) -> None:
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    scene = load(glb, tmp_path)
    assert scene.materials[0].albedo == (1.0, 1.0, 1.0)
    assert not any("metal" in note for note in scene.notes)


def test_layers_that_are_not_drawn_are_listed_once(glb, tmp_path: Path) -> None:
    extensions = {"KHR_materials_sheen": {}, "KHR_materials_clearcoat": {}}
    glb.json["materials"] = [{"name": name, "extensions": extensions} for name in "abcde"]
    primitives = [{**glb.triangle(), "material": index} for index in range(5)]
    glb.json["meshes"] = [{"primitives": primitives}]
    (note,) = [note for note in load(glb, tmp_path).notes if "material beneath" in note]
    assert "sheen (a, b, c and 2 more)" in note
    assert "clear coats (a, b, c and 2 more)" in note


def test_a_mesh_without_normals_has_none(glb, tmp_path: Path) -> None:
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    assert load(glb, tmp_path).meshes[0].normals is None


def test_normals_are_kept_and_made_unit(glb, tmp_path: Path) -> None:
    normals = glb.accessor(np.array([[0, 0, 2]] * 3, dtype="<f4"), "VEC3")
    glb.json["meshes"] = [{"primitives": [glb.triangle(NORMAL=normals)]}]
    assert load(glb, tmp_path).meshes[0].normals.tolist() == [[0, 0, 1]] * 3


def test_vertex_colours_are_linear_and_exact(glb, tmp_path: Path) -> None:
    colors = np.array([[0.1, 0.2, 0.3], [0.0, 0.5, 1.0], [1.0, 1.0, 1.0]], dtype="<f4")
    index = glb.accessor(colors, "VEC3")
    glb.json["meshes"] = [{"primitives": [glb.triangle(COLOR_0=index)]}]
    loaded = load(glb, tmp_path).meshes[0].colors
    assert np.array_equal(loaded[:, :3], colors.astype(np.float64))
    assert loaded[:, 3].tolist() == [1.0] * 3


def test_normalised_integers_are_fractions(glb, tmp_path: Path) -> None:
    colors = np.array([[255, 0, 51, 128]] * 3, dtype="|u1")
    index = glb.accessor(colors, "VEC4", normalized=True)
    glb.json["meshes"] = [{"primitives": [glb.triangle(COLOR_0=index)]}]
    loaded = load(glb, tmp_path).meshes[0].colors
    assert loaded[0] == pytest.approx([1.0, 0.0, 0.2, 128 / 255])


def test_instanced_nodes_share_one_mesh(glb, tmp_path: Path) -> None:
    glb.json["scenes"] = [{"nodes": [0]}]
    glb.json["nodes"] = [
        {"translation": [1, 0, 0], "children": [1, 2]},
        {"mesh": 0, "rotation": [0, 0, 2**-0.5, 2**-0.5]},
        {"mesh": 0, "scale": [2, 3, 4], "matrix": None},
    ]
    del glb.json["nodes"][2]["matrix"]
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    scene = load(glb, tmp_path)
    assert len(scene.meshes) == 1
    (item,) = scene.objects
    turned, scaled = item.world_from_object
    # A quarter turn about +z, then the parent's move.
    assert turned @ [1, 0, 0, 1] == pytest.approx([1, 1, 0, 1])
    assert scaled @ [1, 1, 1, 1] == pytest.approx([3, 3, 4, 1])


def test_matrices_are_column_major(glb, tmp_path: Path) -> None:
    glb.json["nodes"] = [{"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1]}]
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    assert load(glb, tmp_path).objects[0].world_from_object[0, :3, 3].tolist() == [5, 6, 7]


def test_a_mirrored_node_keeps_its_front(glb, tmp_path: Path) -> None:
    glb.json["nodes"] = [{"mesh": 0, "scale": [-1, 1, 1]}]
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    scene = load(glb, tmp_path)
    (item,) = scene.objects
    mesh = scene.meshes[item.mesh]
    a, b, c = transform_points(item.world_from_object[0], mesh.positions)[mesh.triangles[0]]
    assert np.cross(b - a, c - a)[2] > 0.0
    assert scene.bounds()[0][0] == -1.0


def test_gpu_instances(glb, tmp_path: Path) -> None:
    offsets = glb.accessor(np.array([[0, 0, 0], [0, 9, 0]], dtype="<f4"), "VEC3")
    glb.json["nodes"] = [
        {
            "mesh": 0,
            "translation": [1, 0, 0],
            "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": offsets}}},
        }
    ]
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    matrices = load(glb, tmp_path).objects[0].world_from_object
    assert matrices[:, :3, 3].tolist() == [[1, 0, 0], [1, 9, 0]]


@pytest.mark.parametrize(
    ("mode", "expected"),
    [(4, [[0, 1, 2]]), (5, [[0, 1, 2], [1, 3, 2]]), (6, [[0, 1, 2], [0, 2, 3]])],
)
def test_lists_strips_and_fans(mode: int, expected: list[list[int]], glb, tmp_path: Path) -> None:
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 1]], dtype="<f4")
    index = glb.accessor(positions, "VEC3")
    primitive = {"attributes": {"POSITION": index}, "mode": mode}
    glb.json["meshes"] = [{"primitives": [primitive]}]
    mesh = load(glb, tmp_path).meshes[0]
    corners = mesh.positions[mesh.triangles]
    assert corners.tolist() == positions[np.array(expected)].tolist()


def test_points_and_lines_are_left_out(glb, tmp_path: Path) -> None:
    primitive = glb.triangle()
    glb.json["meshes"] = [{"primitives": [primitive, {**primitive, "mode": 1}]}]
    scene = load(glb, tmp_path)
    assert len(scene.objects) == 1
    assert "1 primitives of lines are not drawn" in scene.notes


def test_indices_of_every_width(glb, tmp_path: Path) -> None:
    primitives = [
        {**glb.triangle(), "indices": glb.accessor(np.array([2, 0, 1], dtype=dtype), "SCALAR")}
        for dtype in ("|u1", "<u2", "<u4")
    ]
    glb.json["meshes"] = [{"primitives": primitives}]
    scene = load(glb, tmp_path)
    assert scene.triangle_count == 3
    for mesh in scene.meshes:
        assert mesh.positions[mesh.triangles[0]].tolist() == [[0, 1, 0], [0, 0, 0], [1, 0, 0]]


def test_interleaved_buffers_and_sparse_accessors(glb, tmp_path: Path) -> None:
    table = np.array([[0, 0, 0, 9], [1, 0, 0, 9], [0, 1, 0, 9]], dtype="<f4")
    view = glb.view(table.tobytes())
    glb.json["bufferViews"][view]["byteStride"] = 16
    replaced = glb.view(np.array([[0, 5, 0]], dtype="<f4").tobytes())
    rows = glb.view(np.array([2], dtype="<u2").tobytes())
    glb.json["accessors"].append(
        {
            "bufferView": view,
            "componentType": 5126,
            "count": 3,
            "type": "VEC3",
            "sparse": {
                "count": 1,
                "indices": {"bufferView": rows, "componentType": 5123},
                "values": {"bufferView": replaced},
            },
        }
    )
    position = len(glb.json["accessors"]) - 1
    glb.json["meshes"] = [{"primitives": [{"attributes": {"POSITION": position}}]}]
    assert load(glb, tmp_path).meshes[0].positions.tolist() == [[0, 0, 0], [1, 0, 0], [0, 5, 0]]


@pytest.mark.parametrize("field", ["count", "byteOffset"])
def test_an_accessor_stays_in_its_buffer(field: str, glb, tmp_path: Path) -> None:
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    glb.json["accessors"][0][field] = 4000
    with pytest.raises(SceneError, match="reaches beyond"):
        load(glb, tmp_path)


def textured(glb, reference: dict[str, object], **attributes: int) -> None:
    """Add one triangle whose base colour texture is an embedded image."""
    image = glb.view(plain_png((10, 20, 30, 40), (2, 2)))
    glb.json["images"] = [{"bufferView": image, "mimeType": "image/png"}]
    glb.json["samplers"] = [{"wrapS": 33071, "wrapT": 33071}, {}]
    glb.json["textures"] = [{"source": 0, "sampler": 0}]
    glb.json["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": reference}}]
    glb.json["meshes"] = [{"primitives": [{**glb.triangle(**attributes), "material": 0}]}]


def test_embedded_textures_and_coordinates(glb, tmp_path: Path) -> None:
    uvs = np.array([[0, 0], [1, 0], [0, 0.25]], dtype="<f4")
    textured(glb, {"index": 0}, TEXCOORD_0=glb.accessor(uvs, "VEC2"))
    scene = load(glb, tmp_path)
    texture = scene.materials[0].albedo_texture
    assert texture is not None
    assert texture.pixels.tolist() == [[[10, 20, 30, 40]] * 2] * 2
    assert texture.wrap == ("clamp", "clamp")
    # The format's v counts downward from the top row, as ours does.
    assert np.array_equal(scene.meshes[0].uvs, uvs)


def test_texture_transform_and_second_coordinate_set(glb, tmp_path: Path) -> None:
    uvs = glb.accessor(np.array([[0, 0], [1, 0], [0, 1]], dtype="<f4"), "VEC2")
    other = glb.accessor(np.zeros((3, 2), dtype="<f4"), "VEC2")
    transform = {"offset": [0.5, 0.25], "scale": [2, 4], "rotation": np.pi / 2, "texCoord": 1}
    reference = {"index": 0, "extensions": {"KHR_texture_transform": transform}}
    textured(glb, reference, TEXCOORD_0=other, TEXCOORD_1=uvs)
    # Khronos' example matrix: translation * rotation * scale, clockwise in v-down uv.
    expected = [[0.5, 0.25], [0.5, -1.75], [4.5, 0.25]]
    assert load(glb, tmp_path).meshes[0].uvs == pytest.approx(np.array(expected), abs=1e-6)


def test_external_files_and_data_uris(write: Write) -> None:
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype="<f4").tobytes()
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}],
        "images": [{"uri": "a%20b.png"}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": "sub/data.bin"}],
    }
    files: dict[str, str | bytes] = {
        "sub/data.bin": positions,
        "a b.png": plain_png((1, 2, 3)),
        "model.gltf": json.dumps(document),
    }
    scene = load_scene(write(files))
    texture = scene.materials[0].albedo_texture
    assert texture is not None
    assert texture.pixels[0, 0].tolist() == [1, 2, 3, 255]
    inline = "data:application/octet-stream;base64," + base64.b64encode(positions).decode()
    document["buffers"] = [{"byteLength": 36, "uri": inline}]
    assert load_scene(write({"inline.gltf": json.dumps(document)})).triangle_count == 1
    # A texture that is missing is told, a buffer that is missing is fatal.
    document["images"] = [{"uri": "../outside.png"}]
    notes = load_scene(write({"outside.gltf": json.dumps(document)})).notes
    assert any("must not leave" in note for note in notes)
    document["buffers"] = [{"byteLength": 36, "uri": "../secret.bin"}]
    with pytest.raises(SceneError, match="must not leave"):
        load_scene(write({"secret.gltf": json.dumps(document)}))


def test_skins_stand_where_their_joints_are(glb, tmp_path: Path) -> None:
    joints = glb.accessor(np.array([[0, 1, 0, 0]] * 3, dtype="|u1"), "VEC4")
    weights = glb.accessor(np.array([[1, 1, 0, 0]] * 3, dtype="<f4"), "VEC4")
    inverse = np.eye(4, dtype="<f4")
    inverse[3, 0] = -1.0  # column-major: moves by -1 in x
    matrices = glb.accessor(np.stack([inverse, inverse]).reshape(2, 16), "MAT4")
    glb.json["scenes"] = [{"nodes": [0, 1, 2]}]
    glb.json["nodes"] = [
        {"mesh": 0, "skin": 0, "translation": [100, 0, 0]},
        {"translation": [2, 0, 0]},
        {"translation": [4, 0, 0]},
    ]
    glb.json["skins"] = [{"joints": [1, 2], "inverseBindMatrices": matrices}]
    glb.json["meshes"] = [{"primitives": [glb.triangle(JOINTS_0=joints, WEIGHTS_0=weights)]}]
    # Half of +2 - 1 and half of +4 - 1; the mesh's own node does not count.
    assert load(glb, tmp_path).bounds()[0].tolist() == [2.0, 0.0, 0.0]


def test_morph_targets_use_their_default_weights(glb, tmp_path: Path) -> None:
    offset = glb.accessor(np.array([[0, 0, 4]] * 3, dtype="<f4"), "VEC3")
    primitive = {**glb.triangle(), "targets": [{"POSITION": offset}]}
    glb.json["meshes"] = [{"primitives": [primitive], "weights": [0.5]}]
    assert load(glb, tmp_path).bounds()[1][2] == 2.0


def test_damaged_triangles_are_dropped_and_counted(glb, tmp_path: Path) -> None:
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [np.nan, 0, 0], [2, 0, 0]], dtype="<f4")
    primitive = {
        "attributes": {"POSITION": glb.accessor(positions, "VEC3")},
        "indices": glb.accessor(np.array([0, 1, 2, 0, 1, 3, 0, 1, 4], dtype="<u2"), "SCALAR"),
    }
    glb.json["meshes"] = [{"primitives": [primitive]}]
    scene = load(glb, tmp_path)
    assert scene.triangle_count == 1
    assert "1 triangles with NaN or infinite corners dropped" in scene.notes
    assert "1 triangles without area dropped" in scene.notes


def test_a_glb_that_trimesh_wrote(tmp_path: Path) -> None:
    box = trimesh.creation.box((1.0, 2.0, 3.0))
    box.visual = trimesh.visual.TextureVisuals(
        material=trimesh.visual.material.PBRMaterial(baseColorFactor=[255, 0, 0, 255])
    )
    world = trimesh.Scene()
    world.add_geometry(box, node_name="a", geom_name="box")
    world.graph.update(
        frame_to="b", matrix=trimesh.transformations.translation_matrix([5, 0, 0]), geometry="box"
    )
    path = tmp_path / "box.glb"
    path.write_bytes(world.export(file_type="glb"))
    scene = load_scene(path, ground="off")
    assert len(scene.meshes) == 1
    assert len(scene.objects[0].world_from_object) == 2
    assert scene.meshes[0].closed
    assert scene.bounds()[0] == pytest.approx([-0.5, -1.0, -1.5])
    assert scene.bounds()[1] == pytest.approx([5.5, 1.0, 1.5])
    assert scene.materials[scene.objects[0].material].albedo == (1.0, 0.0, 0.0)
