"""The scenes that are shipped, and real models where they are at hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ssdo_gl.scene.animate import scene_at
from ssdo_gl.scene.environment.environment_kinds import ConstantEnvironment, GradientEnvironment
from ssdo_gl.scene.lights import RectangleLight
from ssdo_gl.scene.load import builtin_names, load_scene
from ssdo_gl.scene.scene import Scene

MODELS = Path(__file__).parents[2].parent / "shared" / "models"
EXPECTED = {
    "carousel",
    "colonnade",
    "coloured_lights",
    "cornell_meso",
    "corner",
    "courtyard",
    "furnace",
    "sphere_on_plane",
    "stairs",
}


def test_every_scene_of_the_set_is_there() -> None:
    assert set(builtin_names()) >= EXPECTED


@pytest.mark.parametrize("name", builtin_names())
def test_a_scene_says_what_it_is_for_and_has_nothing_to_excuse(name: str) -> None:
    scene = load_scene(name)
    assert scene.title
    assert len(scene.purpose) > 60
    assert "\n" not in scene.purpose
    assert scene.notes == ()
    assert scene.render["radius"] > 0.0


@pytest.mark.parametrize("name", builtin_names())
def test_loading_twice_gives_the_same_scene(name: str) -> None:
    one, two = load_scene(name), load_scene(name)
    assert len(one.objects) == len(two.objects)
    for a, b in zip(one.objects, two.objects, strict=True):
        assert np.array_equal(a.world_from_object, b.world_from_object)
        assert (a.mesh, a.material, a.light, a.name) == (b.mesh, b.material, b.light, b.name)
    assert one.lights == two.lights


def instances(scene: Scene, material: str, shape: str) -> int:
    return sum(
        len(item.world_from_object)
        for item in scene.objects
        if scene.materials[item.material].name == material and scene.meshes[item.mesh].name == shape
    )


def test_cornell_meso_is_the_room_of_the_report() -> None:
    scene = load_scene("cornell_meso")
    low, high = scene.bounds()
    assert low.tolist() == [-1, -1, -1]
    assert high.tolist() == [1, 1, 1]
    assert instances(scene, "blue", "box") == 6
    assert instances(scene, "white", "box") == 2
    assert 85 <= instances(scene, "red", "box") + 8 <= 115
    assert len([mesh for mesh in scene.meshes if mesh.name == "box"]) == 1
    lamp, window = scene.lights
    assert isinstance(lamp, RectangleLight)
    assert isinstance(window, RectangleLight)
    assert np.cross(lamp.edge_u, lamp.edge_v)[1] < 0.0  # down
    assert np.cross(window.edge_u, window.edge_v)[2] < 0.0  # into the room
    assert window.shadow == "ssdo"
    assert scene.render["radius"] == 0.3
    red, green = (scene.materials[i].albedo for i in (1, 2))
    assert red[0] > 5.0 * red[1]
    assert green[1] > 2.0 * green[0]


def test_colonnade_is_heavy_through_instances() -> None:
    scene = load_scene("colonnade")
    assert scene.triangle_count >= 300_000
    assert sum(len(mesh.triangles) for mesh in scene.meshes) < 100_000


def test_scenes_without_lights_are_lit_by_their_sky() -> None:
    courtyard, sphere = load_scene("courtyard"), load_scene("sphere_on_plane")
    assert courtyard.lights == ()
    assert isinstance(courtyard.environment, GradientEnvironment)
    assert sphere.lights == ()
    assert isinstance(sphere.environment, ConstantEnvironment)


def test_the_furnace_is_closed_and_shines_inward() -> None:
    scene = load_scene("furnace")
    assert len(scene.lights) == 6
    for light in scene.lights:
        assert isinstance(light, RectangleLight)
        assert light.radiance == (0.5, 0.5, 0.5)
        middle = np.array(light.corner) + 0.5 * (np.array(light.edge_u) + np.array(light.edge_v))
        assert np.cross(light.edge_u, light.edge_v) @ middle == pytest.approx(-4.0)
    assert np.abs(scene.camera.position).max() < 1.0


def test_the_carousel_moves_and_others_do_not() -> None:
    for name in builtin_names():
        scene = load_scene(name)
        assert (scene_at(scene, 1.0) is not scene) == (name == "carousel")
        assert scene.moves == (name == "carousel")


def test_the_coloured_lights_are_red_and_green_and_shadowed_by_ssdo() -> None:
    red, green = load_scene("coloured_lights").lights
    assert isinstance(red, RectangleLight)
    assert isinstance(green, RectangleLight)
    assert red.radiance[0] > 5.0 * red.radiance[1]
    assert green.radiance[1] > 5.0 * green.radiance[0]
    assert red.shadow == green.shadow == "ssdo"


@pytest.mark.parametrize(
    ("name", "triangles", "meshes", "closed", "normals"),
    [
        ("BoxTextured.glb", 12, 1, True, True),
        ("CesiumMilkTruck.glb", 3624, 4, None, True),
        ("Duck.glb", 4212, 1, None, True),
        ("CornellBox-Original.obj", 36, 8, None, False),
        ("CornellBox-Sphere.obj", 2188, 8, None, True),
        ("bunny.ply", 16301, 1, False, True),
    ],
)
def test_real_models_load(
    name: str, triangles: int, meshes: int, closed: bool | None, normals: bool
) -> None:
    if not (MODELS / name).is_file():
        pytest.skip("the folder of real models is not at hand")
    scene = load_scene(MODELS / name)
    assert scene.triangle_count == triangles
    assert len(scene.meshes) == meshes
    assert all((mesh.normals is not None) == normals for mesh in scene.meshes)
    if closed is not None:
        assert scene.meshes[0].closed == closed
    assert scene.lights
    low, high = scene.bounds()
    assert np.all(high > low)


def test_the_lamp_of_a_real_cornell_box_shines_down() -> None:
    path = MODELS / "CornellBox-Original.obj"
    if not path.is_file():
        pytest.skip("the folder of real models is not at hand")
    scene = load_scene(path)
    (light,) = scene.lights
    assert isinstance(light, RectangleLight)
    assert light.radiance == (17.0, 12.0, 4.0)
    assert np.cross(light.edge_u, light.edge_v)[1] < 0.0
    forward = np.subtract(scene.camera.target, scene.camera.position)
    assert forward / np.linalg.norm(forward) == pytest.approx([0, 0, -1], abs=1e-9)
