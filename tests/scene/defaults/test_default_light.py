"""What light a scene gets that a file does not bring, and what takes its place when asked."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from glb_writer import GlbWriter
from image_bytes import png

import ssdo_gl
from ssdo_gl.scene import defaults
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment.environment_kinds import GradientEnvironment, MapEnvironment
from ssdo_gl.scene.geometry import shapes
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings.fields import SettingError

BOX = shapes.box()
SUN = {"type": "directional", "intensity": 3.0}


def saved(glb: GlbWriter, folder: Path, lamp: dict[str, Any] | None = None, **more: Any) -> Path:
    """Return a file with one box, its material as given, and perhaps a lamp from the front."""
    corners = BOX.positions[BOX.triangles].reshape(-1, 3)
    uvs = np.tile([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], (len(corners) // 3, 1))
    attributes = {
        "POSITION": glb.accessor(corners.astype("<f4"), "VEC3"),
        "TEXCOORD_0": glb.accessor(uvs.astype("<f4"), "VEC2"),
    }
    glb.json["meshes"] = [{"primitives": [{"attributes": attributes, "material": 0}]}]
    glb.json["materials"] = [{"pbrMetallicRoughness": {"metallicFactor": 0}, **more}]
    glb.json["nodes"] = [{"mesh": 0}]
    if lamp is not None:
        glb.json["extensions"] = {"KHR_lights_punctual": {"lights": [lamp]}}
        glb.json["nodes"] += [{"extensions": {"KHR_lights_punctual": {"light": 0}}}]
    glb.json["scenes"] = [{"nodes": list(range(len(glb.json["nodes"])))}]
    return glb.save(folder / "a.glb")


def mean_seen(scene: Scene) -> float:
    image = ssdo_gl.render(scene, size=(64, 36), aov="beauty")
    return float(image[image[..., 3] > 0.0, :3].mean())


def test_a_few_glowing_texels_are_no_light(glb: GlbWriter, tmp_path: Path) -> None:
    """Four texels of 64 glow; that the factor is 1 says nothing about the rest."""
    texels = np.zeros((8, 8, 3), np.uint8)
    texels[:2, :2] = 255
    (tmp_path / "glow.png").write_bytes(png(texels))
    glb.json["images"] = [{"uri": "glow.png"}]
    glb.json["textures"] = [{"source": 0}]
    path = saved(glb, tmp_path, emissiveFactor=[1, 1, 1], emissiveTexture={"index": 0})
    scene = load_scene(path)
    assert scene.environment == defaults.SKY
    assert [light.name for light in scene.lights][-1] == "key light"
    assert any("leaves most of the picture dark" in note for note in scene.notes)
    assert load_scene(path, light="file").environment is None


def test_a_sun_keeps_its_place_and_gets_a_dim_grey_sky(glb: GlbWriter, tmp_path: Path) -> None:
    path = saved(glb, tmp_path, SUN)
    scene = load_scene(path)
    assert len(scene.lights) == 1
    sky = scene.environment
    assert isinstance(sky, GradientEnvironment)
    for color in (sky.zenith, sky.horizon, sky.ground):
        assert color[0] == color[1] == color[2]
    # What faces the sun reflects 0.8 x 3 / pi = 0.76 at most.
    assert 0.01 < sky.zenith[0] < 0.2
    for choice in ({"no_default_light": True}, {"light": "file"}):
        assert load_scene(path, **choice).environment is None
    with pytest.raises(SettingError, match="no_default_light belongs to light auto: 'studio'"):
        load_scene(path, no_default_light=True, light="studio")


@pytest.mark.parametrize("strength", [1e-6, 1e6])
def test_the_dim_sky_follows_the_strength_of_the_lamps(
    strength: float, glb: GlbWriter, tmp_path: Path
) -> None:
    scene = load_scene(saved(glb, tmp_path, {**SUN, "intensity": strength}))
    assert isinstance(scene.environment, GradientEnvironment)
    if strength > 1.0:  # a weaker one lights nothing
        assert 0.01 * strength / 3 < scene.environment.zenith[0] < 0.2 * strength / 3


def test_metal_without_a_lamp_gets_a_room_to_reflect(glb: GlbWriter, tmp_path: Path) -> None:
    path = saved(glb, tmp_path)
    assert load_scene(path).environment == defaults.SKY
    chosen = load_scene(path, light="studio")
    assert isinstance(chosen.environment, MapEnvironment)
    assert 0.2 < mean_seen(chosen) < 1.0


def test_a_white_surface_stays_within_the_range_of_the_picture() -> None:
    camera = Camera((1.0, 1.0, 3.0), (0.0, 0.0, 0.0))
    _, key = defaults.studio(camera)
    quad = shapes.quad()
    assert quad.normals is None or len(quad.normals)
    sky, _ = defaults.studio(camera)
    assert float(sky.image.min()) > 0.0
    # Soft boxes are what metal shows: several times as bright as the walls.
    assert float(sky.image.max()) > 5.0 * float(np.median(sky.image))
    assert np.allclose(np.linalg.norm(key.direction), 1.0)


def test_a_map_takes_the_place_of_the_lamps(glb: GlbWriter, tmp_path: Path) -> None:
    path = saved(glb, tmp_path, SUN)
    # Radiance HDR, 2 x 1, mantissa 128 and exponent 129: one half times two is 1 everywhere.
    sky = tmp_path / "sky.hdr"
    header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n"
    sky.write_bytes(header + bytes([128, 128, 128, 129] * 2))
    scene = load_scene(path, light=str(sky))
    assert not scene.lights
    assert isinstance(scene.environment, MapEnvironment)
    assert scene.environment.image == pytest.approx(1.0, rel=0.01)
    assert any("1 light of the file left out" in note for note in scene.notes)


def test_a_scene_file_may_be_seen_in_other_light() -> None:
    scene = load_scene("cornell_meso", light="studio")
    assert [light.name for light in scene.lights] == ["key light"]
    assert all(item.light is None for item in scene.objects)
    assert load_scene("cornell_meso").environment is None


@pytest.mark.parametrize("light", ["studoi", "", "a.png", "nosuch.hdr"])
def test_other_light_is_refused_in_one_line(light: str, glb: GlbWriter, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"^light = ") as caught:
        load_scene(saved(glb, tmp_path), light=light)
    assert "\n" not in str(caught.value)
    # Said once, whether quoted or not.
    assert not light or str(caught.value).count(light) == 1


def test_an_unknown_option_names_the_nearest() -> None:
    with pytest.raises(SettingError, match="'light'"):
        load_scene("corner", lihgt="file")


def test_the_frame_is_fitted_in_place_of_the_camera_of_the_file() -> None:
    own, fitted = load_scene("corner"), load_scene("corner", frames_all=True)
    assert own.camera != fitted.camera
    assert fitted.camera.fov_y == own.camera.fov_y
