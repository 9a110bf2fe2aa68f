"""A glTF file that lies, or holds absurd values, is one line or a note; never more."""

from __future__ import annotations

import base64
import tracemalloc
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
import pytest
from glb_writer import GlbWriter, load
from image_bytes import plain_png

from ssdo_gl.scene.lights import DirectionalLight, PointLight, RectangleLight
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene_error import SceneError


def refusal(glb: GlbWriter, folder: Path) -> str:
    with pytest.raises(SceneError) as caught:
        load(glb, folder)
    message = str(caught.value)
    assert "\n" not in message
    assert len(message) < 300
    return message


def one_triangle(glb: GlbWriter, **primitive: Any) -> dict[str, Any]:
    glb.json["meshes"] = [{"primitives": [{**glb.triangle(), **primitive}]}]
    return glb.json


@pytest.mark.parametrize(
    ("node", "named"),
    [
        ({"translation": [float("nan"), 0, 0]}, "node 0: translation"),
        ({"translation": [0, float("inf"), 0]}, "node 0: translation"),
        ({"translation": [1e300, 0, 0]}, "node 0: translation"),
        ({"translation": [1e20, 0, 0]}, "node 0 lies or reaches beyond 1e+15"),
        ({"scale": [1, 1, 1e20]}, "node 0 lies or reaches beyond 1e+15"),
        ({"scale": [1, 1, "1"]}, "node 0: scale"),
        ({"scale": [1, 1]}, "node 0: scale"),
        ({"rotation": [0, 0, float("nan"), 1]}, "node 0: rotation"),
        ({"matrix": [float("nan")] + [0] * 15}, "node 0: matrix"),
        ({"matrix": [10**400] + [0] * 15}, "node 0: matrix"),
    ],
)
@pytest.mark.parametrize("what", ["mesh", "camera"])
def test_places_are_finite_or_refused_by_name(
    node: dict[str, Any], named: str, what: str, glb: GlbWriter, tmp_path: Path
) -> None:
    json = one_triangle(glb)
    json["nodes"] = [{**node, what: 0}, {"mesh": 0}]
    json["scenes"] = [{"nodes": [0, 1]}]
    json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}]
    assert named in refusal(glb, tmp_path)


@pytest.mark.parametrize(
    ("material", "named"),
    [
        ({"emissiveFactor": [1e300, 0, 0]}, "material 'm': emissiveFactor"),
        (
            {
                "emissiveFactor": [1, 1, 1],
                "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 1e39}},
            },
            "material 'm': emissiveStrength",
        ),
        ({"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1e39]}}, "baseColorFactor"),
        ({"alphaMode": "MASK", "alphaCutoff": float("nan")}, "alphaCutoff"),
    ],
)
def test_materials_are_finite_or_refused_by_name(
    material: dict[str, Any], named: str, glb: GlbWriter, tmp_path: Path
) -> None:
    one_triangle(glb, material=0)["materials"] = [{"name": "m", **material}]
    assert named in refusal(glb, tmp_path)


@pytest.mark.parametrize("intensity", ["1e39", "1e300", "NaN", "null", "1" * 5000])
def test_lights_are_finite_or_refused_by_name(
    intensity: str, glb: GlbWriter, tmp_path: Path
) -> None:
    document = one_triangle(glb)
    lights = [{"type": "directional", "intensity": "?"}]
    document["extensions"] = {"KHR_lights_punctual": {"lights": lights}}
    document["nodes"][0]["extensions"] = {"KHR_lights_punctual": {"light": 0}}
    path = tmp_path / "a.gltf"
    path.write_text(glb.text().replace('"?"', intensity))
    with pytest.raises(SceneError, match=r"light 0: |too many digits"):
        load_scene(path)


@pytest.mark.parametrize(
    ("place", "named"),
    [
        (("nodes", 0, "mesh"), "meshes -1"),
        (("scene",), "scenes -1"),
        (("scenes", 0, "nodes", 0), "nodes -1"),
        (("meshes", 0, "primitives", 0, "attributes", "POSITION"), "accessors -1"),
        (("meshes", 0, "primitives", 0, "material"), "materials -1"),
        (("accessors", 0, "bufferView"), "bufferViews -1"),
        (("bufferViews", 0, "buffer"), "buffers -1"),
    ],
)
def test_minus_one_is_not_the_last(
    place: tuple[str | int, ...], named: str, glb: GlbWriter, tmp_path: Path
) -> None:
    one_triangle(glb)["materials"] = [{}]
    target: Any = glb.json
    for key in place[:-1]:
        target = target[key]
    target[place[-1]] = -1
    assert f"refers to {named}, but there are" in refusal(glb, tmp_path)


@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({"asset": {"version": "[" * 2000}}, "glTF version '[["),
        ({"extensionsRequired": ["E" * 2000]}, "requires the extension 'EE"),
        (
            {"extensions": {"KHR_lights_punctual": {"lights": [{"type": "t" * 2000}]}}},
            "light 0: unknown type 'tt",
        ),
    ],
)
def test_long_texts_of_a_file_are_cut_in_messages(
    changed: dict[str, Any], named: str, glb: GlbWriter, tmp_path: Path
) -> None:
    one_triangle(glb).update(changed)
    glb.json["nodes"][0]["extensions"] = {"KHR_lights_punctual": {"light": 0}}
    assert named in refusal(glb, tmp_path)


def test_zeros_out_of_nothing_have_a_limit(glb: GlbWriter, tmp_path: Path) -> None:
    document = one_triangle(glb)
    document["accessors"] += [
        {"componentType": 5126, "count": 1 << 22, "type": kind}
        for kind in ("VEC3", "VEC3", "VEC4", "VEC4")
    ]
    attributes = {"POSITION": 1, "NORMAL": 2, "JOINTS_0": 3, "WEIGHTS_0": 4}
    document["meshes"][0]["primitives"][0]["attributes"] = attributes
    tracemalloc.start()
    try:
        message = refusal(glb, tmp_path)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert "zeros in all" in message
    assert peak < 1 << 30


@pytest.mark.parametrize(
    ("kind", "key", "named"),
    [
        ("MAT4", "POSITION", "MAT4 of 16 numbers, expected 3"),
        ("SCALAR", "NORMAL", "SCALAR of 1 numbers, expected 3"),
        ("VEC3", "TEXCOORD_0", "VEC3 of 3 numbers, expected 2"),
    ],
)
def test_elements_of_the_wrong_width(
    kind: str, key: str, named: str, glb: GlbWriter, tmp_path: Path
) -> None:
    document = one_triangle(glb)
    document["accessors"].append({"componentType": 5126, "count": 3, "type": kind})
    document["meshes"][0]["primitives"][0]["attributes"][key] = 1
    assert named in refusal(glb, tmp_path)


def test_indices_are_whole_numbers(glb: GlbWriter, tmp_path: Path) -> None:
    floats = glb.accessor(np.array([0, 1, 2], dtype="<f4"), "SCALAR")
    one_triangle(glb, indices=floats)
    assert "indices must be unsigned integers" in refusal(glb, tmp_path)


def test_instances_have_a_limit_and_are_read_at_once(glb: GlbWriter, tmp_path: Path) -> None:
    document = one_triangle(glb)
    count = 1 << 15
    places = np.arange(3 * count, dtype="<f4").reshape(-1, 3)
    glb.accessor(places, "VEC3")
    extension = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1}}}
    document["nodes"][0]["extensions"] = extension
    (item,) = load(glb, tmp_path).objects
    assert item.world_from_object[:, :3, 3].tolist() == places.tolist()
    document["accessors"][1]["count"] = 1 << 24
    del document["accessors"][1]["bufferView"]
    assert f"{1 << 24} instances: at most {1 << 20}" in refusal(glb, tmp_path)


def test_instances_without_places_are_one(glb: GlbWriter, tmp_path: Path) -> None:
    document = one_triangle(glb)
    document["accessors"].append({"componentType": 5126, "count": 1 << 20, "type": "VEC3"})
    extension = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1}}}
    document["nodes"][0]["extensions"] = extension
    (item,) = load(glb, tmp_path).objects
    assert item.world_from_object.tolist() == [np.eye(4).tolist()]


def test_many_nodes_of_one_mesh_are_read_at_once(glb: GlbWriter, tmp_path: Path) -> None:
    one_triangle(glb)["nodes"] = [{"mesh": 0, "translation": [i, 0, 0]} for i in range(2_000)]
    glb.json["scenes"] = [{"nodes": list(range(2_000))}]
    (item,) = load(glb, tmp_path).objects
    assert item.world_from_object[:, 0, 3].tolist() == list(range(2_000))


def textured(glb: GlbWriter, uri: str) -> None:
    uvs = glb.accessor(np.zeros((3, 2), dtype="<f4"), "VEC2")
    document = glb.json
    document["meshes"] = [{"primitives": [{**glb.triangle(TEXCOORD_0=uvs), "material": 0}]}]
    document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    document["textures"] = [{"source": 0}]
    document["images"] = [{"uri": uri}]


PLAIN = base64.b64encode(plain_png((1, 2, 3))).decode()


@pytest.mark.parametrize(
    "uri",
    [
        f"data:image/png;base64,{PLAIN}",
        f"data:image/png;BASE64,{PLAIN}",
        f"DATA:;base64,{PLAIN}",
        f"data:image/png;base64,{PLAIN[:20]}\r\n \t{PLAIN[20:]}\n",
        f"data:image/png;base64,{PLAIN.rstrip('=')}",
        f"data:image/png;base64,{quote(PLAIN, safe='')}",
        f"data:image/png;base64,{PLAIN.replace('+', '-').replace('/', '_')}",
        "data:image/png," + "".join(f"%{byte:02x}" for byte in plain_png((1, 2, 3))),
    ],
)
def test_data_uris_of_every_style(uri: str, glb: GlbWriter, tmp_path: Path) -> None:
    textured(glb, uri)
    texture = load(glb, tmp_path).materials[0].albedo_texture
    assert texture is not None
    assert texture.pixels.tolist() == [[[1, 2, 3, 255]]]


def test_a_name_with_escapes_or_a_stray_percent(glb: GlbWriter, tmp_path: Path) -> None:
    for name, uri in (("a b.png", "a%20b.png"), ("50%.png", "50%.png"), ("5%20.png", "5%20.png")):
        (tmp_path / name).write_bytes(plain_png((9, 9, 9)))
        textured(glb, uri)
        assert load(glb, tmp_path).materials[0].albedo_texture is not None


@pytest.mark.parametrize(
    "uri",
    [
        "data:image/png;base64,bm90aGluZw==",
        "data:image/png;base64,!!!!",
        "data:image/png",
        "x" * 300,
        "missing.png",
        "../outside.png",
        17,
    ],
)
def test_a_texture_that_cannot_be_used_is_a_note(uri: Any, glb: GlbWriter, tmp_path: Path) -> None:
    textured(glb, uri)
    scene = load(glb, tmp_path)
    assert scene.materials[0].albedo_texture is None
    (note,) = [note for note in scene.notes if note.startswith("texture not used: ")]
    assert "BytesIO" not in note
    assert scene.triangle_count == 1


@pytest.mark.parametrize("place", [("textures", "source"), ("textures", "sampler")])
def test_a_reference_of_a_texture_that_does_not_exist(
    place: tuple[str, str], glb: GlbWriter, tmp_path: Path
) -> None:
    textured(glb, f"data:;base64,{PLAIN}")
    glb.json[place[0]][0][place[1]] = -1
    scene = load(glb, tmp_path)
    assert scene.materials[0].albedo_texture is None
    assert any(note.startswith("texture not used: refers to") for note in scene.notes)


def test_morph_weights_of_a_node_win_over_the_mesh(glb: GlbWriter, tmp_path: Path) -> None:
    offset = glb.accessor(np.array([[0, 0, 4]] * 3, dtype="<f4"), "VEC3")
    primitive = {**glb.triangle(), "targets": [{"POSITION": offset}]}
    glb.json["meshes"] = [{"primitives": [primitive], "weights": [0.5]}]
    glb.json["nodes"] = [{"mesh": 0}, {"mesh": 0, "weights": [1.0]}, {"mesh": 0, "weights": [0.25]}]
    glb.json["scenes"] = [{"nodes": [0, 1, 2]}]
    scene = load(glb, tmp_path)
    heights = [float(scene.meshes[o.mesh].positions[0, 2]) for o in scene.objects]
    assert heights == [2.0, 4.0, 1.0]


def test_light_numbers_that_are_fine_stay(glb: GlbWriter, tmp_path: Path) -> None:
    document = one_triangle(glb)
    document["extensions"] = {
        "KHR_lights_punctual": {
            "lights": [
                {"type": "directional", "intensity": 3, "color": [1, 0.5, 0]},
                {"type": "point"},
            ]
        }
    }
    document["nodes"] = [
        {"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": n}}} for n in (0, 1)
    ]
    document["scenes"] = [{"nodes": [0, 1]}]
    first, second = load(glb, tmp_path).lights
    assert isinstance(first, DirectionalLight)
    assert first.irradiance == (3.0, 1.5, 0.0)
    assert isinstance(second, PointLight)
    assert second.intensity == (1.0, 1.0, 1.0)


@pytest.mark.parametrize(
    ("place", "value", "named"),
    [
        (["nodes", 0, "extensions"], "x", "nodes 0: extensions is 'x': expected an object"),
        (["nodes", 0, "extensions"], {"KHR_lights_punctual": "x"}, "KHR_lights_punctual is 'x'"),
        (["materials"], {"a": {}}, "materials is {'a': {}}: expected a list of objects"),
        (["materials", 0, "pbrMetallicRoughness"], "x", "materials 0: pbrMetallicRoughness is 'x'"),
        (["meshes", 0, "primitives", 0], "x", "meshes 0: primitives 0 is 'x'"),
        (["meshes", 0, "primitives", 0, "attributes"], 3, "primitives 0: attributes is 3"),
        (["meshes"], [{}], "not valid glTF: 'primitives' is missing"),
        (["asset"], "2.0", "asset is '2.0': expected {"),
        (["asset"], {"version": "1.0"}, "glTF version '1.0': expected 2.0"),
        (["accessors"], 3, "accessors is 3: expected a list of objects"),
    ],
)
def test_a_value_in_the_place_of_another_is_named_with_its_place(
    place: list[Any], value: object, named: str, glb: GlbWriter, tmp_path: Path
) -> None:
    json: Any = one_triangle(glb, material=0)
    json["materials"] = [{}]
    for key in place[:-1]:
        json = json[key]
    json[place[-1]] = value
    assert named in refusal(glb, tmp_path)


def test_glowing_surfaces_and_a_lamp_are_lights_both(glb: GlbWriter, tmp_path: Path) -> None:
    json = one_triangle(glb, material=0)
    json["materials"] = [{"emissiveFactor": [1, 1, 1]}]
    json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 9}]}}
    lamp = {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [1, 1, 1]}
    json["nodes"] += [lamp]
    json["scenes"] = [{"nodes": [0, 1]}]
    scene = load(glb, tmp_path)
    assert any(isinstance(light, PointLight) and light.place == (1, 1, 1) for light in scene.lights)
    assert any(isinstance(light, RectangleLight) for light in scene.lights)
