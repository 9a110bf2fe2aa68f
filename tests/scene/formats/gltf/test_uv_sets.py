"""The images of one material may each have texture coordinates of their own."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from glb_writer import MIRROR, REPEAT, GlbWriter
from image_bytes import GREYS, png_uri
from numpy.typing import NDArray

import ssdo_gl
from ssdo_gl.color import linear_from_srgb
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene

CORNERS = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype="<f4")
# Black everywhere but in the last quarter.
LAMP = np.kron(np.array([[0, 0], [0, 255]], dtype=np.uint8), np.ones((8, 8), np.uint8))
SQUARES = np.kron(GREYS, np.ones((8, 8), np.uint8))


def square(
    glb: GlbWriter, height: float, sets: list[NDArray[np.float64]], **more: Any
) -> dict[str, Any]:
    """Return a primitive: a square of -1..1 that faces +z."""
    positions = np.concatenate([2.0 * CORNERS - 1.0, np.full((4, 1), height)], axis=1)
    uvs = {f"TEXCOORD_{i}": glb.accessor(uv.astype("<f4"), "VEC2") for i, uv in enumerate(sets)}
    return {
        "attributes": {"POSITION": glb.accessor(positions.astype("<f4"), "VEC3"), **uvs},
        "indices": glb.accessor(np.array([0, 1, 2, 0, 2, 3], dtype="<u2"), "SCALAR"),
        **more,
    }


def material(glow: dict[str, Any] | None, **more: Any) -> dict[str, Any]:
    base = {"baseColorTexture": {"index": 0}, "metallicFactor": 0}
    images = {} if glow is None else {"emissiveTexture": {"index": 1, **glow}}
    return {"pbrMetallicRoughness": base, "emissiveFactor": [1, 1, 1], **images, **more}


def load(glb: GlbWriter, folder: Path, *nodes: dict[str, Any]) -> Scene:
    glb.json["textures"] = [{"source": 0, "sampler": 0}, {"source": 1, "sampler": 1}]
    glb.json.setdefault("samplers", [{"wrapS": REPEAT, "wrapT": REPEAT}] * 2)
    glb.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.5 * np.pi}}]
    glb.json["nodes"] = [{"mesh": 0}, *nodes]
    glb.json["scenes"] = [{"nodes": list(range(len(glb.json["nodes"])))}]
    return load_scene(glb.save(folder / "a.glb"))


FLIP = {"KHR_texture_transform": {"scale": [-1, 1], "offset": [1, 0]}}


@pytest.mark.parametrize("glow", [{"texCoord": 1}, {"extensions": FLIP}])
def test_emission_and_albedo_use_their_own_coordinates(
    glow: dict[str, Any], glb: GlbWriter, tmp_path: Path
) -> None:
    upward = CORNERS * [1, -1] + [0, 1]
    sets = [upward, upward * [-1, 1] + [1, 0]]
    glb.json["meshes"] = [{"primitives": [square(glb, 0.0, sets, material=0)]}]
    glb.json["materials"] = [material(glow)]
    glb.json["images"] = [{"uri": png_uri(SQUARES)}] * 2
    scene = load(glb, tmp_path, {"camera": 0, "translation": [0, 0, 1]})
    linear = linear_from_srgb(GREYS / 255.0)
    for aov, expected in (("albedo", linear), ("emission", linear[:, ::-1])):
        image = ssdo_gl.render(scene, size=(32, 32), aov=aov)
        assert image[8::16, 8::16, 0] == pytest.approx(expected, abs=2e-3)


def test_only_the_mirrored_image_is_mirrored(glb: GlbWriter, tmp_path: Path) -> None:
    sets = [(CORNERS * [1, -1] + [0, 1]) * [2, 1]]
    glb.json["samplers"] = [{"wrapS": MIRROR}, {"wrapS": REPEAT}]
    glb.json["meshes"] = [{"primitives": [square(glb, 0.0, sets, material=0)]}]
    glb.json["materials"] = [material({})]
    glb.json["images"] = [{"uri": png_uri(SQUARES)}] * 2
    scene = load(glb, tmp_path, {"camera": 0, "translation": [0, 0, 1]})
    linear = linear_from_srgb(GREYS / 255.0)
    for aov, columns in (("albedo", [0, 1, 1, 0]), ("emission", [0, 1, 0, 1])):
        image = ssdo_gl.render(scene, size=(32, 32), aov=aov)
        assert image[8::16, 4::8, 0] == pytest.approx(linear[:, columns], abs=2e-3)


@pytest.mark.parametrize("mode", ["OPAQUE", "MASK"])
def test_rays_meet_the_emission_where_the_second_set_has_it(
    mode: str, glb: GlbWriter, tmp_path: Path
) -> None:
    # By the first set the lamp is black, by the second it is one of constant radiance.
    sets = [0.1 + 0.1 * CORNERS, 0.7 + 0.1 * CORNERS]
    lights = []
    for glow in ({"texCoord": 1}, None):
        lamp = square(glb, 0.0, sets, material=0)
        floor = square(glb, 0.0, sets, material=1)
        glb.json["meshes"] = [{"primitives": [lamp]}, {"primitives": [floor]}]
        plain = {"pbrMetallicRoughness": {"metallicFactor": 0}, "doubleSided": True}
        glb.json["materials"] = [material(glow, alphaMode=mode), plain]
        # The lamp's alpha: a hole where the second set points, none where the first does.
        rgba = np.full((16, 16, 4), 255, np.uint8)
        rgba[8:, 8:, 3] = 0
        glb.json["images"] = [{"uri": png_uri(rgba)}, {"uri": png_uri(LAMP)}]
        scene = load(
            glb,
            tmp_path,
            {"mesh": 1, "translation": [0, 0, 1], "scale": [0.5, 0.5, 1]},
            {"camera": 0, "translation": [0, 0, 0.2], "rotation": [0, 1, 0, 0]},
        )
        lights.append(
            ssdo_gl.render(scene, method="reference-gi", size=(16, 16), spp=16, exposure=0.0)
        )
    assert lights[1].mean() > 0.01
    assert lights[0] == pytest.approx(lights[1], rel=1e-4, abs=1e-6)


@pytest.mark.parametrize("method", ["reference-gi", "direct"])
def test_another_image_on_the_second_set_leaves_the_emission_where_it_is(
    method: str, glb: GlbWriter, tmp_path: Path
) -> None:
    # By the first set the lamp is one of constant radiance, by the second it is black.
    sets = [0.7 + 0.1 * CORNERS, 0.1 + 0.1 * CORNERS]
    lights = []
    for occlusion in ({"index": 0, "texCoord": 1}, {"index": 0}):
        lamp, floor = (square(glb, 0.0, sets, material=i) for i in range(2))
        glb.json["meshes"] = [{"primitives": [lamp]}, {"primitives": [floor]}]
        plain = {"pbrMetallicRoughness": {"metallicFactor": 0}, "doubleSided": True}
        glb.json["materials"] = [material({}, occlusionTexture=occlusion), plain]
        glb.json["images"] = [{"uri": png_uri(SQUARES)}, {"uri": png_uri(LAMP)}]
        scene = load(
            glb,
            tmp_path,
            {"mesh": 1, "translation": [0, 0, 1], "scale": [0.5, 0.5, 1]},
            {"camera": 0, "translation": [0, 0, 0.2], "rotation": [0, 1, 0, 0]},
        )
        lights.append(ssdo_gl.render(scene, method=method, size=(16, 16), spp=16, exposure=0.0))
    assert lights[1].mean() > 0.01
    assert lights[0] == pytest.approx(lights[1], rel=1e-4, abs=1e-6)
