"""A model without camera or light of its own is seen from its front, and well lit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from glb_writer import GlbWriter
from image_bytes import png
from numpy.typing import NDArray
from PIL import Image

import ssdo_gl
from ssdo_gl import math3d
from ssdo_gl.scene.defaults.framing import frame
from ssdo_gl.scene.geometry import Surfaces, shapes
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene

QUAD, BOX = shapes.quad(), shapes.box()


def degrees_off(front: tuple[float, float, float], matrix: NDArray[np.float64]) -> float:
    """Return the angle between a sheet's front and the way to the camera."""
    camera = frame(Surfaces([QUAD], [SceneObject(0, 0, matrix[None])]), 40.0, 0.0)
    toward = math3d.normalized(np.subtract(camera.position, camera.target))
    return float(np.degrees(np.arccos(np.clip(toward @ math3d.normalized(front), -1.0, 1.0))))


@pytest.mark.parametrize("turn", [0.0, 45.0, 90.0, 180.0, 250.0])
@pytest.mark.parametrize("scale", [1.0, 1e-4, 1e6])
def test_a_poster_is_seen_from_its_front(turn: float, scale: float) -> None:
    matrix = math3d.rotation_euler((0.0, turn, 0.0)) @ math3d.scaling((scale, 2.0 * scale, scale))
    front = matrix[:3, 2]
    # Thirty degrees to the right and twenty above.
    expected = np.degrees(np.arccos(np.cos(np.radians(30.0)) * np.cos(np.radians(20.0))))
    assert degrees_off(tuple(front), matrix) == pytest.approx(expected, abs=0.1)


def test_a_thin_board_is_seen_from_plus_z() -> None:
    for size in ((4.0, 3.0, 0.05), (0.05, 3.0, 4.0)):
        camera = frame(Surfaces([BOX], [SceneObject(0, 0, math3d.scaling(size)[None])]), 40.0, 0.0)
        toward = math3d.normalized(np.subtract(camera.position, camera.target))
        assert toward[int(np.argmin(size))] > 0.75


def test_a_floor_is_still_seen_from_above() -> None:
    lying = math3d.rotation_euler((-90.0, 0.0, 0.0))
    camera = frame(Surfaces([QUAD], [SceneObject(0, 0, lying[None])]), 40.0, 0.0)
    assert camera.position[1] > camera.target[1]


def solid(glb: GlbWriter, low: float, high: float, **material: Any) -> None:
    """Add a closed box as a mesh and a node of its own."""
    positions = (BOX.positions * (high - low) + 0.5 * (low + high)).astype("<f4")
    primitive = {
        "attributes": {"POSITION": glb.accessor(positions, "VEC3")},
        "indices": glb.accessor(BOX.triangles.reshape(-1).astype("<u2"), "SCALAR"),
        "material": len(glb.json.setdefault("materials", [])),
    }
    glb.json["materials"].append({"pbrMetallicRoughness": {"metallicFactor": 0}, **material})
    glb.json.setdefault("meshes", []).append({"primitives": [primitive]})


def drawn(glb: GlbWriter, folder: Path) -> tuple[Scene, NDArray[np.float32]]:
    count = len(glb.json["meshes"])
    glb.json["nodes"] = [{"mesh": n} for n in range(count)] + glb.json.get("more", [])
    glb.json.pop("more", None)
    glb.json["scenes"] = [{"nodes": list(range(len(glb.json["nodes"])))}]
    scene = load_scene(glb.save(folder / "a.glb"))
    images = {name: ssdo_gl.render(scene, size=(96, 54), aov=name) for name in ("beauty", "depth")}
    brightness = images["beauty"][..., :3].mean(axis=2) * 2.0**scene.camera.exposure
    return scene, brightness[images["depth"][..., 0] > 0.0]


def test_one_glowing_part_leaves_no_model_black(glb: GlbWriter, tmp_path: Path) -> None:
    solid(glb, -1.0, 1.0)
    solid(glb, 1.0, 1.1, emissiveFactor=[0, 1, 1])
    scene, seen = drawn(glb, tmp_path)
    assert abs(scene.camera.exposure) <= 1.0
    assert np.percentile(seen, 10) > 0.05
    assert any("leaves most of the picture dark" in note for note in scene.notes)


@pytest.mark.parametrize("glow", [1e-4, 1e-30])
def test_a_glow_next_to_nothing_leaves_no_picture_black(
    glow: float, glb: GlbWriter, tmp_path: Path
) -> None:
    """All that the camera sees glows, evenly, and so little that it would show black."""
    solid(glb, -1.0, 1.0, emissiveFactor=[glow] * 3)
    _, seen = drawn(glb, tmp_path)
    assert 0.1 < seen.mean() < 1.0


@pytest.mark.parametrize("glow", [1e-3, 1e-30])
def test_emission_next_to_nothing_raises_no_exposure(
    glow: float, glb: GlbWriter, tmp_path: Path
) -> None:
    solid(glb, -1.0, 1.0, emissiveFactor=[glow] * 3)
    solid(glb, -1.5, -1.2)
    scene, seen = drawn(glb, tmp_path)
    assert abs(scene.camera.exposure) <= 1.0
    assert 0.1 < seen.mean() < 1.0


@pytest.mark.parametrize("strength", [1e-25, 1e-3, 1.0, 1e5, 1e12])
def test_a_lamp_of_any_strength_shows_all_sides(
    strength: float, glb: GlbWriter, tmp_path: Path
) -> None:
    solid(glb, -1.0, 1.0)
    lights = [{"type": "point", "intensity": strength}]
    glb.json["extensions"] = {"KHR_lights_punctual": {"lights": lights}}
    glb.json["more"] = [
        {"translation": [3, 0, -4], "extensions": {"KHR_lights_punctual": {"light": 0}}}
    ]
    _, seen = drawn(glb, tmp_path)
    assert np.percentile(seen, 5) > 0.03
    assert np.percentile(seen, 90) < 2.0


def test_a_white_picture_of_sixteen_bits_is_not_made_up(glb: GlbWriter, tmp_path: Path) -> None:
    path = tmp_path / "grey.png"
    path.write_bytes(png(np.full((2, 2), 16384, dtype=np.uint16)))
    with Image.open(path) as texture:
        assert texture.mode.startswith("I")
    uvs = glb.accessor(np.zeros((3, 2), dtype="<f4"), "VEC2")
    glb.json["meshes"] = [{"primitives": [{**glb.triangle(TEXCOORD_0=uvs), "material": 0}]}]
    base = {"baseColorTexture": {"index": 0}, "metallicFactor": 0}
    glb.json["materials"] = [{"pbrMetallicRoughness": base}]
    glb.json["textures"] = [{"source": 0}]
    glb.json["images"] = [{"uri": "grey.png"}]
    scene = load_scene(glb.save(tmp_path / "a.glb"))
    albedo = ssdo_gl.render(scene, size=(32, 32), aov="albedo")
    # A quarter of the code is 0.0513 of the light.
    assert albedo.max() == pytest.approx(0.0513, abs=1e-3)


def test_a_sheet_seen_edge_on_has_a_finite_exposure(glb: GlbWriter, tmp_path: Path) -> None:
    document = glb.json
    document["meshes"] = [{"primitives": [glb.triangle()]}]
    lights = [{"type": "point", "intensity": 5}]
    document["extensions"] = {"KHR_lights_punctual": {"lights": lights}}
    document["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1.0}}]
    document["nodes"] = [
        {"mesh": 0},
        {"camera": 0, "translation": [0.25, -3, 0], "rotation": [0.5**0.5, 0, 0, 0.5**0.5]},
        {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [0, 0, 1]},
    ]
    document["scenes"] = [{"nodes": [0, 1, 2]}]
    scene = load_scene(glb.save(tmp_path / "a.glb"))
    assert scene.camera.target[1] > -3.0
    assert -10.0 < scene.camera.exposure < 8.0
