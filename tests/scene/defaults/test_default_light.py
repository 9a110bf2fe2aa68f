"""The light and the floor a scene gets that a file does not bring, and what replaces them."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from glb_writer import GlbWriter
from image_bytes import png

import ssdo_gl
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene import defaults
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.defaults.default_light import BACKDROP
from ssdo_gl.scene.environment.environment_kinds import GradientEnvironment, MapEnvironment
from ssdo_gl.scene.geometry import shapes
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
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


@pytest.mark.parametrize(
    ("glow", "base", "is_added"), [(0.11, 1, True), (0.11, 0, False), (1, 1, False)]
)
def test_what_glows_by_less_than_light_on_it_would_bring_is_no_light(
    glb: GlbWriter, tmp_path: Path, glow: float, base: float, is_added: bool
) -> None:
    path = saved(glb, tmp_path, emissiveFactor=[glow] * 3)
    glb.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = [base] * 3 + [1]
    assert (load_scene(glb.save(path)).environment is not None) is is_added


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


CORNERS = "".join(f"v {x} {y} {z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1))
SIDES = "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"
FLOOR = "v -2 0 -2\nv -2 0 3\nv 3 0 3\nv 3 0 -2\nf 9 10 11 12\n"


@pytest.fixture
def box(tmp_path: Path) -> Path:
    path = tmp_path / "box.obj"
    path.write_text(CORNERS + SIDES)
    return path


def grounds(scene: Scene) -> int:
    return sum(item.is_ground for item in scene.objects)


def test_a_lone_model_stands_on_a_ground_that_its_size_does_not_count(box: Path) -> None:
    scene, bare = load_scene(box, ground="auto"), load_scene(box)
    assert (grounds(scene), grounds(bare)) == (1, 0)
    assert scene.camera == bare.camera
    assert scene.default_radius() == bare.default_radius()
    np.testing.assert_array_equal(scene.bounds(), bare.bounds())
    (mesh,) = (scene.meshes[item.mesh] for item in scene.objects if item.is_ground)
    # Just below the box, by less than one sees.
    assert -1e-3 < mesh.positions[:, 1].max() < 0.0
    assert (mesh.face_normals()[:, 1] > 0.99).all()


def test_no_ground_where_something_else_serves(box: Path) -> None:
    box.write_text(CORNERS + SIDES + FLOOR)
    assert grounds(load_scene(box, ground="auto")) == 0
    box.write_text(CORNERS + SIDES)
    assert grounds(load_scene(box, light="file", ground="auto")) == 0
    assert grounds(load_scene(box, light="studio", ground="auto")) == 1
    assert load_scene("corner", light="studio").has_ground is False


def test_no_ground_between_the_light_and_what_is_seen_from_below(
    glb: GlbWriter, tmp_path: Path
) -> None:
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    glb.json["nodes"][0]["rotation"] = [2**-0.5, 0, 0, 2**-0.5]
    scene = load_scene(glb.save(tmp_path / "on_its_face.glb"), ground="auto")
    assert scene.camera.position[1] < 0.0
    assert grounds(scene) == 0


def test_a_cut_out_stands_on_nothing(box: Path) -> None:
    image = ssdo_gl.render(str(box), size=(48, 27), background="transparent")
    assert image[-1, 0, 3] == 0.0
    assert ssdo_gl.render(str(box), size=(48, 27))[-1, 0, 3] == 1.0


def test_the_ground_goes_and_comes_with_the_background(box: Path) -> None:
    scene = load_scene(box, ground="auto")
    settings = Settings(size=(48, 27), method="direct")
    cut_out = dataclasses.replace(settings, background="transparent")
    with Renderer(scene, cut_out) as renderer:
        clear = renderer.render().images["beauty"]
        renderer.use(settings)
        shown = renderer.render().images["beauty"]
        renderer.use(cut_out)
        assert np.array_equal(renderer.render().images["beauty"], clear)
    assert clear[-1, 0, 3] == 0.0 and shown[-1, 0, 3] == 1.0
    bare = ssdo_gl.render(load_scene(box), size=(48, 27), method="direct", background="transparent")
    assert np.array_equal(clear, bare)


@pytest.mark.parametrize("light", ["auto", "studio"])
def test_the_ground_has_no_edge(box: Path, light: str) -> None:
    """Unshaded it shows the backdrop: to a twentieth, which is what SSDO leaves of noise."""
    scene = load_scene(box, light=light, ground="auto")
    with Renderer(scene, Settings(size=(96, 54))) as renderer:
        images = renderer.render(["beauty", "position_ws"]).images
    position = images["position_ws"]
    is_ground = (position[..., 1] < -1e-6) & (images["beauty"][..., 3] > 0.0)
    far = is_ground & (np.hypot(position[..., 0] - 0.5, position[..., 2] - 0.5) > 1.2)
    # On the side of the light, where the box throws no shadow.
    lit = far & (position[..., 2] > 0.5)
    shown = images["beauty"][lit][:, :3]
    assert len(shown) > 20
    assert np.median(shown) == pytest.approx(BACKDROP[0], rel=0.05)
    assert shown[is_ground[lit]].min() > 0.5 * BACKDROP[0]


def test_the_ground_does_not_decide_the_exposure(box: Path, tmp_path: Path) -> None:
    (tmp_path / "a.mtl").write_text("newmtl lamp\nKd 0.001 0.001 0.001\n")
    box.write_text(f"mtllib a.mtl\nusemtl lamp\n{CORNERS}{SIDES}")
    with Renderer(load_scene(box, ground="auto"), Settings(size=(48, 27))) as renderer:
        exposure = renderer.render(["display"]).settings.exposure
    # Black as it is, it is raised as far as the grey behind it allows; that grey alone would
    # leave exposure at 0.
    assert exposure == 1.0
