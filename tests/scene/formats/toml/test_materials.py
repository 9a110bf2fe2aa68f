"""Materials of scene files."""

from __future__ import annotations

import pytest
from scene.fixture_types import Write

from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene


def scene(text: str) -> Scene:
    return read_description(text, "scene.toml")


def test_materials() -> None:
    result = scene(
        """
        [materials.m]
        albedo = [0.1, 0.2, 0.3]
        emission = [0, 0, 0]
        alpha = 0.5
        alpha_cutoff = 0.25
        [[object]]
        shape = "sphere"
        radius = 1
        material = "m"
        """
    )
    material = result.materials[0]
    assert material.name == "m"
    assert material.albedo == (0.1, 0.2, 0.3)
    assert (material.alpha, material.alpha_cutoff) == (0.5, 0.25)
    assert not material.emits


@pytest.mark.parametrize(
    ("keys", "count"),
    [("", 1), ("alpha_cutoff = 0.2", 0), ("blend = true", 0), ("blend = false", 1)],
)
def test_an_alpha_that_nothing_reads_is_said(keys: str, count: int) -> None:
    objects = '[[object]]\nshape = "sphere"\nradius = 1\nmaterial = "m"'
    notes = scene(f"[materials.m]\nalpha = 0.5\n{keys}\n{objects}").notes
    said = [note for note in notes if "[materials.m] alpha" in note and "opacity = 0.5" in note]
    assert len(said) == count


def test_a_mesh_file_takes_the_material_of_the_scene(write: Write) -> None:
    obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    file = write(
        {
            "models/tri.obj": obj,
            "s.toml": '[materials.red]\nalbedo = [1, 0, 0]\n[[object]]\nshape = "mesh"\n'
            'path = "models/tri.obj"\nmaterial = "red"\n[[object]]\nshape = "mesh"\n'
            'path = "models/tri.obj"\ntransform = { scale = 2 }\nname = "own"\n',
        }
    )
    result = load_scene(file)
    albedos = [result.materials[item.material].albedo for item in result.objects]
    assert albedos == [(1.0, 0.0, 0.0), (0.8, 0.8, 0.8)]
    assert result.bounds()[1].tolist() == [2.0, 2.0, 0.0]


BOX = '[[object]]\nshape = "box"\nmin = [0, 0, 0]\nmax = [1, 1, 1]\nmaterial = "m"\n'


@pytest.mark.parametrize(
    ("keys", "specular", "is_glossy"),
    [
        ("", 0.0, False),
        ("roughness = 0.2", 1.0, True),
        ("metallic = 1", 1.0, True),
        ("roughness = 0.2\nspecular = 0", 0.0, False),
        ("specular = 0.5", 0.5, True),
        ("ior = 1", 1.0, False),
    ],
)
def test_gloss_is_asked_for_by_any_of_its_keys(keys: str, specular: float, is_glossy: bool) -> None:
    result = scene(f"[materials.m]\n{keys}\n{BOX}")
    material = result.materials[result.objects[0].material]
    assert material.specular == specular
    assert material.is_glossy == is_glossy


def test_a_dielectric_of_ior_1_5_reflects_4_percent() -> None:
    result = scene(f"[materials.m]\nroughness = 1\n{BOX}")
    material = result.materials[result.objects[0].material]
    assert material.dielectric_color == pytest.approx((0.04,) * 3)
