"""Values of glTF files that have no meaning: drawn as the nearest that has one, and said once."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from glb_writer import GlbWriter, load

from ssdo_gl.scene.scene import Scene

SAID = "values without a meaning, drawn as the nearest: "


def with_materials(glb: GlbWriter, folder: Path, *materials: dict[str, Any]) -> Scene:
    glb.json["materials"] = [{"name": f"m{i}", **each} for i, each in enumerate(materials)]
    glb.json["meshes"] = [
        {"primitives": [{**glb.triangle(), "material": i} for i in range(len(materials))]}
    ]
    return load(glb, folder)


def said(scene: Scene) -> str:
    (note,) = [note for note in scene.notes if note.startswith(SAID)]
    return note.removeprefix(SAID)


def specular(**fields: Any) -> dict[str, Any]:
    return {"extensions": {"KHR_materials_specular": fields}}


def ior(value: float) -> dict[str, Any]:
    return {"extensions": {"KHR_materials_ior": {"ior": value}}}


def base(**fields: Any) -> dict[str, Any]:
    return {"pbrMetallicRoughness": fields}


@pytest.mark.parametrize(
    ("material", "field", "drawn", "text"),
    [
        (base(metallicFactor=7), "metallic", 1.0, "metallicFactor 7 as 1"),
        (base(roughnessFactor=-1), "roughness", 0.0, "roughnessFactor -1 as 0"),
        (
            base(baseColorFactor=[2, -0.5, 0.25, 1]),
            "albedo",
            (1.0, 0.0, 0.25),
            "baseColorFactor [2, -0.5, 0.25, 1] as [1, 0, 0.25, 1]",
        ),
        (base(baseColorFactor=[1, 1, 1, 3]), "alpha", 1.0, "baseColorFactor [1, 1, 1, 3] as [1, 1"),
        (
            specular(specularColorFactor=[-1, 0, 2]),
            "specular_color",
            (0.0, 0.0, 2.0),
            "specularColorFactor [-1, 0, 2] as [0, 0, 2]",
        ),
        (specular(specularFactor=1.5), "specular", 1.0, "specularFactor 1.5 as 1"),
        (
            {"emissiveFactor": [0, -1, 3]},
            "emission",
            (0.0, 0.0, 3.0),
            "emissiveFactor times emissiveStrength [0, -1, 3] as [0, 0, 3]",
        ),
        ({"alphaMode": "blend"}, "blends", False, "alphaMode 'blend' as OPAQUE"),
        (ior(-2), "ior", 1.5, "ior -2 as 1.5"),
    ],
)
def test_the_nearest_is_drawn_and_said(
    material: dict[str, Any], field: str, drawn: object, text: str, glb: GlbWriter, tmp_path: Path
) -> None:
    scene = with_materials(glb, tmp_path, material)
    assert getattr(scene.materials[0], field) == drawn
    assert text in said(scene)
    assert "(material 'm0')" in said(scene)


def test_an_index_below_one_reflects_as_its_inverse(glb: GlbWriter, tmp_path: Path) -> None:
    """At normal incidence ((n - 1) / (n + 1))^2 is the same, which is what viewers draw."""
    scene = with_materials(glb, tmp_path, ior(0.59))
    assert scene.materials[0].dielectric_color == pytest.approx([(0.41 / 1.59) ** 2] * 3)
    assert said(scene) == "ior 0.59 as 1.69 (material 'm0')"


def test_many_users_of_one_value_are_one_line(glb: GlbWriter, tmp_path: Path) -> None:
    scene = with_materials(glb, tmp_path, *[ior(0.5)] * 5, *[ior(0.8)] * 2)
    assert said(scene) == (
        "ior 0.5 as 2 (material 'm0', material 'm1', material 'm2' and 2 more); "
        "ior 0.8 as 1.25 (material 'm5', material 'm6')"
    )


def test_many_values_are_one_short_line(glb: GlbWriter, tmp_path: Path) -> None:
    scene = with_materials(glb, tmp_path, *[ior(0.1 * i) for i in range(1, 9)])
    assert said(scene).count("ior") == 4
    assert said(scene).endswith("; and 4 more")


def test_roundings_are_not_said(glb: GlbWriter, tmp_path: Path) -> None:
    scene = with_materials(
        glb, tmp_path, base(metallicFactor=1.0005, baseColorFactor=[1.001, 1, 1, 1])
    )
    assert (scene.materials[0].metallic, scene.materials[0].albedo) == (1.0, (1.0, 1.0, 1.0))
    assert not any(note.startswith(SAID) for note in scene.notes)


@pytest.mark.parametrize(
    ("light", "text"),
    [
        ({"type": "point", "intensity": -5}, "colour times intensity [-5, -5, -5] as [0, 0, 0]"),
        ({"type": "spot", "spot": {"outerConeAngle": 3.0}}, "outerConeAngle 3 as 1.5708"),
    ],
)
def test_lights(light: dict[str, Any], text: str, glb: GlbWriter, tmp_path: Path) -> None:
    glb.json["extensions"] = {"KHR_lights_punctual": {"lights": [light]}}
    glb.json["nodes"] = [{"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}]
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    assert f"{text} (light 0)" in said(load(glb, tmp_path))


def test_a_rotation_of_no_length_turns_nothing(glb: GlbWriter, tmp_path: Path) -> None:
    glb.json["nodes"] = [{"mesh": 0, "rotation": [0, 0, 0, 0], "translation": [1, 2, 3]}]
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    scene = load(glb, tmp_path)
    assert scene.objects[0].world_from_object[0, :3, :3] == pytest.approx(np.eye(3))
    assert said(scene) == "rotation [0, 0, 0, 0] as none (node 0)"


def test_an_unknown_interpolation_is_linear(glb: GlbWriter, tmp_path: Path) -> None:
    times = glb.accessor(np.array([0, 1], dtype="<f4"), "SCALAR")
    values = glb.accessor(np.array([[0, 0, 0], [4, 0, 0]], dtype="<f4"), "VEC3")
    glb.json["animations"] = [
        {
            "samplers": [{"input": times, "output": values, "interpolation": 0}],
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
        }
    ]
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    scene = load(glb, tmp_path)
    assert said(scene) == "interpolation 0 as LINEAR (node 0)"
    motion = scene.objects[0].motion
    assert motion is not None
    moved = motion.world_from_rest(0.25) @ scene.objects[0].world_from_object[0]
    assert moved[:3, 3] == pytest.approx([1, 0, 0])
