"""What of glTF's materials arrives in the scene, and where their images lie."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from documentation.pages import ROOT
from glb_writer import MIRROR, GlbWriter, load
from image_bytes import png_uri

from ssdo_gl.scene.formats.gltf.allowed import EXTENSIONS
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene
from ssdo_gl.scene.scene_error import SceneError

PIXELS = np.arange(2 * 2 * 4, dtype=np.uint8).reshape(2, 2, 4) * 10


def with_material(glb: GlbWriter, folder: Path, **material: Any) -> Scene:
    """Return the scene of one triangle with two sets of texture coordinates."""
    sets = [np.array([[0, 0], [1, 0], [0, 1]]), np.array([[0.5, 0], [1, 0.25], [0, 1]])]
    uvs = {f"TEXCOORD_{i}": glb.accessor(uv.astype("<f4"), "VEC2") for i, uv in enumerate(sets)}
    glb.json["materials"] = [material]
    glb.json["meshes"] = [{"primitives": [{**glb.triangle(**uvs), "material": 0}]}]
    glb.json.setdefault("textures", [{"source": 0}])
    glb.json["images"] = [{"uri": png_uri(PIXELS)}]
    return load(glb, folder)


def read(glb: GlbWriter, folder: Path, **material: Any) -> Material:
    return with_material(glb, folder, **material).materials[0]


def test_the_numbers_of_metallic_roughness(glb: GlbWriter, tmp_path: Path) -> None:
    base = {"baseColorFactor": [0.5, 0.25, 0.125, 0.75], "metallicFactor": 0.4}
    base["roughnessFactor"] = 0.3
    extensions = {
        "KHR_materials_ior": {"ior": 1.8},
        "KHR_materials_specular": {"specularFactor": 0.6, "specularColorFactor": [2, 0.5, 1]},
    }
    material = read(glb, tmp_path, pbrMetallicRoughness=base, extensions=extensions)
    assert (material.metallic, material.roughness) == (0.4, 0.3)
    assert (material.specular, material.specular_color) == (0.6, (2.0, 0.5, 1.0))
    assert material.ior == 1.8
    assert material.dielectric_color == pytest.approx(np.multiply((0.8 / 2.8) ** 2, (2, 0.5, 1)))
    assert not material.is_unlit
    assert not material.blends


def test_what_is_left_out_is_as_the_format_has_it(glb: GlbWriter, tmp_path: Path) -> None:
    material = read(glb, tmp_path, name="plain")
    assert (material.metallic, material.roughness, material.specular) == (1.0, 1.0, 1.0)
    assert material.ior == 1.5
    # No material at all is dull white: nobody means metal.
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    assert not load(glb, tmp_path).materials[0].is_glossy


def test_images_of_colour_and_of_numbers(glb: GlbWriter, tmp_path: Path) -> None:
    image = {"index": 0}
    material = read(
        glb,
        tmp_path,
        pbrMetallicRoughness={"baseColorTexture": image, "metallicRoughnessTexture": image},
        normalTexture={**image, "scale": 0.5},
        occlusionTexture={**image, "strength": 0.25},
        emissiveTexture=image,
        emissiveFactor=[1, 1, 1],
        extensions={
            "KHR_materials_specular": {"specularTexture": image, "specularColorTexture": image}
        },
    )
    assert set(material.textures) == {
        *("albedo", "metallic_roughness", "normal", "occlusion", "emission"),
        *("specular", "specular_color"),
    }
    data = {name for name, texture in material.textures.items() if texture.is_data}
    assert data == {"metallic_roughness", "normal", "occlusion", "specular"}
    assert all(np.array_equal(texture.pixels, PIXELS) for texture in material.textures.values())
    # One image for all that read it alike: it is uploaded once.
    assert material.normal_texture is material.occlusion_texture
    assert (material.normal_scale, material.occlusion_strength) == (0.5, 0.25)
    assert material.second_uvs == frozenset()


def test_unlit_and_blended_materials_are_marked(glb: GlbWriter, tmp_path: Path) -> None:
    material = read(
        glb, tmp_path, alphaMode="BLEND", extensions={"KHR_materials_unlit": {}}, doubleSided=True
    )
    assert material.is_unlit
    assert material.blends
    assert not material.single_sided


@pytest.mark.parametrize(
    ("mode", "alpha", "blends"),
    [("OPAQUE", 0.575, True), ("BLEND", 0.23, True), ("MASK", 0.4, False)],
)
def test_thin_transmission_is_blended(
    mode: str, alpha: float, blends: bool, glb: GlbWriter, tmp_path: Path
) -> None:
    scene = with_material(
        glb,
        tmp_path,
        name="pane",
        alphaMode=mode,
        pbrMetallicRoughness={"baseColorFactor": [1, 1, 1, 0.4]},
        extensions={"KHR_materials_transmission": {"transmissionFactor": 0.5}},
    )
    material = scene.materials[0]
    assert material.blends == blends
    assert material.alpha == pytest.approx(alpha)
    assert any("refraction" in note and "pane" in note for note in scene.notes) == blends


def test_two_sets_of_coordinates_serve_all_images(glb: GlbWriter, tmp_path: Path) -> None:
    shifted = {"KHR_texture_transform": {"offset": [0.5, 0], "scale": [2, 2]}}
    scene = with_material(
        glb,
        tmp_path,
        pbrMetallicRoughness={
            "baseColorTexture": {"index": 0, "texCoord": 1},
            "metallicRoughnessTexture": {"index": 0, "extensions": shifted},
        },
        occlusionTexture={"index": 0, "extensions": shifted},
        normalTexture={"index": 0, "texCoord": 1},
    )
    (mesh,), (material,) = scene.meshes, scene.materials
    assert material.second_uvs == {"metallic_roughness", "occlusion"}
    assert mesh.uvs is not None
    assert mesh.uvs.tolist() == [[0.5, 0], [1, 0.25], [0, 1]]
    assert mesh.second_uvs is not None
    assert mesh.second_uvs.tolist() == [[0.5, 0], [2.5, 0], [0.5, 2]]


def test_a_third_set_of_coordinates_is_named(glb: GlbWriter, tmp_path: Path) -> None:
    half = {"KHR_texture_transform": {"scale": [0.5, 1]}}
    scene = with_material(
        glb,
        tmp_path,
        name="tiles",
        pbrMetallicRoughness={"baseColorTexture": {"index": 0}},
        normalTexture={"index": 0, "texCoord": 1},
        occlusionTexture={"index": 0, "extensions": half},
    )
    assert scene.materials[0].second_uvs == {"normal"}
    (note,) = [note for note in scene.notes if "third set" in note]
    assert "'tiles'" in note
    assert "occlusion" in note


def test_an_image_that_is_mirrored_leaves_the_others_in_place(
    glb: GlbWriter, tmp_path: Path
) -> None:
    glb.json["samplers"] = [{"wrapS": MIRROR}]
    glb.json["textures"] = [{"source": 0, "sampler": 0}, {"source": 0}]
    scene = with_material(
        glb,
        tmp_path,
        pbrMetallicRoughness={"baseColorTexture": {"index": 0}},
        normalTexture={"index": 1},
    )
    material = scene.materials[0]
    assert material.second_uvs == frozenset()
    assert scene.meshes[0].uvs is not None
    assert scene.meshes[0].uvs.tolist() == [[0, 0], [0.5, 0], [0, 1]]
    albedo, normal = material.albedo_texture, material.normal_texture
    assert albedo is not None
    assert normal is not None
    assert np.array_equal(albedo.pixels, np.concatenate([PIXELS, PIXELS[:, ::-1]], axis=1))
    assert np.array_equal(normal.pixels, np.concatenate([PIXELS, PIXELS], axis=1))


def test_specular_glossiness_becomes_its_nearest_kin(glb: GlbWriter, tmp_path: Path) -> None:
    older = {
        "diffuseFactor": [0.5, 0.5, 0.5, 1],
        "specularFactor": [0.2, 0.3, 0.4],
        "glossinessFactor": 0.75,
    }
    extensions = {"KHR_materials_pbrSpecularGlossiness": older}
    material = read(glb, tmp_path, extensions=extensions)
    assert material.albedo == (0.5, 0.5, 0.5)
    assert material.metallic == 0.0
    assert material.roughness == 0.25
    assert material.dielectric_color == pytest.approx((0.2, 0.3, 0.4))
    older["specularGlossinessTexture"] = {"index": 0}  # type: ignore[assignment]
    material = read(glb, tmp_path, extensions=extensions)
    assert material.roughness == 1.0
    assert material.metallic_roughness_texture is not None
    rough = material.metallic_roughness_texture.pixels[..., 1]
    assert rough.tolist() == np.rint(255 - 0.75 * PIXELS[..., 3]).tolist()
    assert material.specular_color_texture is not None
    assert not material.specular_color_texture.is_data


@pytest.mark.parametrize(
    ("material", "message"),
    [
        ({"extensions": {"KHR_materials_ior": {"ior": "2"}}}, "ior = '2': expected a number"),
        ({"pbrMetallicRoughness": {"roughnessFactor": 1e39}}, "roughnessFactor = 1e"),
        ({"normalTexture": {"index": 0, "scale": None}}, "scale = None"),
    ],
)
def test_bad_numbers_are_refused_by_name(
    material: Any, message: str, glb: GlbWriter, tmp_path: Path
) -> None:
    with pytest.raises(SceneError, match=message):
        read(glb, tmp_path, **material)


@pytest.mark.parametrize("name", ["normalTexture", "occlusionTexture"])
def test_a_missing_image_is_a_note(name: str, glb: GlbWriter, tmp_path: Path) -> None:
    scene = with_material(glb, tmp_path, **{name: {"index": 9}})
    assert not scene.materials[0].textures
    assert any("texture not used" in note for note in scene.notes)


def test_the_table_of_extensions_is_the_readers_own() -> None:
    text = (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")
    section = text.split("### Extensions", 1)[1].split("\n## ", 1)[0]
    rows = dict(re.findall(r"^\| (\w+) \| (exact|approximate|not drawn)\b", section, re.MULTILINE))
    assert rows == EXTENSIONS
