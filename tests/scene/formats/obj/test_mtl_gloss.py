"""Gloss, bumps and opacity of .mtl materials."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from image_bytes import png
from numpy.typing import NDArray
from scene.fixture_types import Write

from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

CARD = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nmtllib a.mtl\nusemtl m\nf 1/1 2/2 3/3\n"


def load(write: Write, mtl: str, **images: NDArray[Any]) -> Scene:
    files: dict[str, str | bytes] = {f"{name}.png": png(image) for name, image in images.items()}
    return load_scene(write({**files, "a.mtl": "newmtl m\n" + mtl, "a.obj": CARD}))


def read(write: Write, mtl: str, **images: NDArray[Any]) -> Material:
    return load(write, mtl, **images).materials[0]


@pytest.mark.parametrize("mtl", ["", "Ks 0 0 0\nNs 500", "Ks 1 1 1\nillum 1", "Ns 90"])
def test_materials_without_gloss_stay_diffuse(mtl: str, write: Write) -> None:
    assert not read(write, f"Kd 0.5 0.5 0.5\n{mtl}").is_glossy


def test_a_highlight_as_exporters_write_it(write: Write) -> None:
    material = read(write, "Kd 0.5 0.5 0.5\nKs 0.5 0.25 1\nNs 1000\nillum 2")
    # Ks 0.5 is a plain dielectric: 4 %.
    assert material.dielectric_color == pytest.approx((0.04, 0.02, 0.08))
    assert material.metallic == 0.0
    assert material.roughness == pytest.approx((2.0 / 1002.0) ** 0.25)


def test_what_reflects_and_hardly_scatters_is_metal(write: Write) -> None:
    material = read(write, "Kd 0.01 0.01 0.01\nKs 0.95 0.8 0.6\nNs 1000\nillum 5")
    assert (material.metallic, material.albedo) == (1.0, (0.95, 0.8, 0.6))
    grey = np.full((2, 2, 3), 128, np.uint8)
    assert read(write, "Kd 0 0 0\nKs 1 1 1\nmap_Kd c.png", c=grey).metallic == 0.0


def test_metal_and_roughness_of_their_own(write: Write) -> None:
    material = read(write, "Kd 0.5 0.5 0.5\nPm 0.75\nPr 0.25\nNs 10\nKs 0.5 0.5 0.5")
    assert (material.metallic, material.roughness, material.specular) == (0.75, 0.25, 1.0)
    rough = np.array([[0, 100], [200, 255]], np.uint8)
    metal = np.array([[255]], np.uint8)
    material = read(write, "map_Pr r.png\nmap_Pm m.png", r=rough, m=metal)
    assert (material.metallic, material.roughness) == (1.0, 1.0)
    texture = material.metallic_roughness_texture
    assert texture is not None
    assert texture.is_data
    assert texture.pixels[..., 1].tolist() == rough.tolist()
    assert texture.pixels[..., 2].tolist() == [[255, 255]] * 2


def test_the_colour_of_highlights_from_an_image(write: Write) -> None:
    material = read(write, "map_Ks s.png", s=np.full((2, 2, 3), 90, np.uint8))
    assert material.specular_color_texture is not None
    assert not material.specular_color_texture.is_data
    assert material.dielectric_color == pytest.approx((0.08, 0.08, 0.08))


@pytest.mark.parametrize("key", ["norm", "map_Kn", "bump", "map_Bump"])
def test_normals_are_taken_as_they_stand(key: str, write: Write) -> None:
    normals = np.full((2, 2, 3), (128, 140, 250), np.uint8)
    texture = read(write, f"{key} n.png", n=normals).normal_texture
    assert texture is not None
    assert texture.is_data
    assert np.all(texture.pixels[..., :3] == normals)


def test_heights_become_normals(write: Write) -> None:
    # Rising to the right by 16 a texel, but for the edge of the repeated image.
    heights = np.tile(np.arange(0, 128, 16, dtype=np.uint8), (8, 1))
    for strength, turned in ((1.0, False), (3.0, False), (1.0, True)):
        image = heights.T[::-1].copy() if turned else heights
        texture = read(write, f"bump -bm {strength} h.png", h=image).normal_texture
        assert texture is not None
        x, y, z = texture.pixels[4, 4, :3] / 127.5 - 1.0
        rise = -y if turned else -x
        assert rise / z == pytest.approx(2.0 * strength * 16 / 255, abs=0.02)
        assert (x if turned else y) == pytest.approx(0.0, abs=0.01)


def test_opacity_is_blending(write: Write) -> None:
    assert read(write, "d 0.25").blends
    assert read(write, "d 0.25").alpha == 0.25
    assert read(write, "Tr 0.25").alpha == 0.75
    # What would not be seen at all is a fault of exporters.
    for mtl in ("d 1", "Tr 0", "d 0", "Tr 1"):
        assert not read(write, mtl).blends
        assert read(write, mtl).alpha == 1.0


def test_images_lie_in_two_places_at_most(write: Write) -> None:
    grey = np.full((2, 2, 3), 100, np.uint8)
    mtl = "map_Kd c.png\nnorm -s 2 2 c.png\nmap_Ks -s 2 2 c.png"
    scene = load(write, mtl, c=grey)
    assert scene.materials[0].second_uvs == {"normal", "specular_color"}
    assert scene.meshes[0].uvs is not None
    assert scene.meshes[0].second_uvs is not None
    assert scene.meshes[0].second_uvs[1, 0] == 2.0 * scene.meshes[0].uvs[1, 0]
    notes = load(write, mtl + "\nmap_Pr -s 3 3 c.png", c=grey).notes
    assert any("third placement" in note for note in notes)


@pytest.mark.parametrize("mtl", ["Ns x", "Ns nan", "Pr 1e39", "Pm -3", "d", "illum two", "norm"])
def test_bad_numbers_do_no_harm(mtl: str, write: Write) -> None:
    material = read(write, mtl)
    assert 0.0 <= material.roughness <= 1.0
    assert 0.0 <= material.metallic <= 1.0
    assert material.alpha == 1.0
