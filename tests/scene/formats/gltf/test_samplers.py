"""Samplers of glTF: each axis wraps by itself, mirrored or not, smoothly or in squares."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from glb_writer import CLAMP, MIRROR, REPEAT, GlbWriter
from image_bytes import GREYS, png_uri
from numpy.typing import NDArray

import ssdo_gl
from ssdo_gl.color import linear_from_srgb
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene


def card(glb: GlbWriter, pixels: NDArray[np.uint8], sampler: dict[str, Any], **more: Any) -> None:
    """Add a square of -1..1 whose texture coordinates run from -1 to 2."""
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=np.float64)
    positions = np.concatenate([2.0 * corners - 1.0, np.zeros((4, 1))], axis=1).astype("<f4")
    uvs = np.stack([3.0 * corners[:, 0] - 1.0, 2.0 - 3.0 * corners[:, 1]], axis=1).astype("<f4")
    primitive = {
        "attributes": {
            "POSITION": glb.accessor(positions, "VEC3"),
            "TEXCOORD_0": glb.accessor(uvs, "VEC2"),
        },
        "indices": glb.accessor(np.array([0, 1, 2, 0, 2, 3], dtype="<u2"), "SCALAR"),
        "material": 0,
    }
    document = glb.json
    document["meshes"] = [{"primitives": [primitive]}]
    base = {"baseColorTexture": {"index": 0}, "metallicFactor": 0}
    document["materials"] = [{"pbrMetallicRoughness": base, "doubleSided": True, **more}]
    document["textures"] = [{"source": 0, "sampler": 0}]
    document["samplers"] = [sampler]
    document["images"] = [{"uri": png_uri(pixels)}]


def load(glb: GlbWriter, folder: Path) -> Scene:
    """Load the file, with a camera that sees the card's square and nothing else."""
    glb.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.5 * np.pi}}]
    glb.json["nodes"] = [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 1]}]
    glb.json["scenes"] = [{"nodes": [0, 1]}]
    return load_scene(glb.save(folder / "a.glb"))


def expected(wrap_s: int, wrap_t: int) -> NDArray[np.float64]:
    """Return albedo in the middle of the 6 x 6 squares that the card shows."""
    place = np.arange(-2, 4)
    index = {REPEAT: place % 2, MIRROR: np.array([0, 1, 0, 1, 1, 0]), CLAMP: np.clip(place, 0, 1)}
    # A mirror image runs backwards on either side.
    index[MIRROR] = np.array([1, 0, 0, 1, 1, 0])
    return linear_from_srgb(GREYS[index[wrap_t]][:, index[wrap_s]] / 255.0)


@pytest.mark.parametrize("wrap_s", [REPEAT, MIRROR, CLAMP])
@pytest.mark.parametrize("wrap_t", [REPEAT, MIRROR, CLAMP])
def test_each_axis_wraps_by_itself(
    wrap_s: int, wrap_t: int, glb: GlbWriter, tmp_path: Path
) -> None:
    card(glb, np.kron(GREYS, np.ones((8, 8), np.uint8)), {"wrapS": wrap_s, "wrapT": wrap_t})
    albedo = ssdo_gl.render(load(glb, tmp_path), size=(96, 96), aov="albedo")[..., 0]
    assert albedo[8::16, 8::16] == pytest.approx(expected(wrap_s, wrap_t), abs=2e-3)


def test_magnified_texels_may_stay_squares(glb: GlbWriter, tmp_path: Path) -> None:
    for kind, is_smooth in ((9728, False), (9729, True)):
        card(glb, GREYS, {"magFilter": kind, "wrapS": CLAMP, "wrapT": CLAMP})
        albedo = ssdo_gl.render(load(glb, tmp_path), size=(96, 96), aov="albedo")[..., 0]
        assert (len(np.unique(np.round(albedo, 3))) > 4) == is_smooth


@pytest.mark.parametrize("kind", [9728, 9729])
@pytest.mark.parametrize(("wrap_s", "wrap_t"), [(CLAMP, REPEAT), (MIRROR, CLAMP), (REPEAT, MIRROR)])
def test_rays_see_what_the_rasterizer_sees(
    wrap_s: int, wrap_t: int, kind: int, glb: GlbWriter, tmp_path: Path
) -> None:
    # The holes of a mask: light that falls through them onto a wall behind.
    alpha = np.array([[255, 0], [0, 0]], dtype=np.uint8)
    pixels = np.stack([np.full((2, 2), 255, np.uint8)] * 3 + [alpha], axis=-1)
    sampler = {"wrapS": wrap_s, "wrapT": wrap_t, "magFilter": kind}
    card(glb, pixels, sampler, alphaMode="MASK")
    walls = np.array([[-4, -4, 0], [4, -4, 0], [4, 4, 0], [-4, 4, 0]], dtype="<f4")
    wall = {
        "attributes": {"POSITION": glb.accessor(walls, "VEC3")},
        "indices": glb.accessor(np.array([0, 1, 2, 0, 2, 3], dtype="<u2"), "SCALAR"),
    }
    glb.json["meshes"].append({"primitives": [wall]})
    sun = {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 3}]}}
    glb.json["extensions"] = sun
    glb.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.5 * np.pi}}]
    glb.json["nodes"] = [
        {"mesh": 0},
        {"mesh": 1, "translation": [0, 0, -1]},
        {"camera": 0, "translation": [0, 0, -0.1]},
        {"extensions": {"KHR_lights_punctual": {"light": 0}}},
    ]
    glb.json["scenes"] = [{"nodes": [0, 1, 2, 3]}]
    scene = load_scene(glb.save(tmp_path / "a.glb"))
    by_map, by_rays = (
        ssdo_gl.render(scene, size=(64, 64), aov="direct", shadows=kind_of_shadow, shadow_rays=1)
        for kind_of_shadow in ("map", "traced")
    )
    assert 0.1 < (by_rays > 0.0).mean() < 0.95
    # They may differ along the edges of the holes.
    assert (np.abs(by_map - by_rays).max(axis=2) > 0.05).mean() < 0.06
