"""What surfaces are made of, changed in a window or by a file, and found by pointing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.material_edits import (
    EDITED,
    edited_material,
    material_at,
    shows_light,
    with_edited,
)
from ssdo_gl.scene.scene import Scene
from ssdo_gl.scene.scene_error import SceneError
from ssdo_gl.settings import Settings
from ssdo_gl.window.saving.scene_files import scene_text

VALUES = {
    "albedo": (0.1, 0.7, 0.3),
    "emission": (0.0, 0.1, 0.4),
    "metallic": 0.5,
    "roughness": 0.4,
    "specular": 0.8,
    "alpha": 0.6,
    "ior": 1.7,
}


@pytest.fixture(scope="module")
def room() -> Scene:
    return load_scene("cornell_meso")


def wall(room: Scene) -> int:
    return next(item.material for item in room.objects if not shows_light(room, item.material))


def test_a_saved_scene_has_every_number_that_was_edited(room: Scene, tmp_path: Path) -> None:
    assert set(VALUES) == set(EDITED)
    index = wall(room)
    edited = with_edited(room, index, edited_material(room.materials[index], VALUES))
    text = scene_text(
        "cornell_meso",
        room,
        load={},
        camera=room.camera,
        lights=room.lights,
        sources=range(len(room.lights)),
        materials=edited.materials,
        environment=room.environment,
        settings=Settings(size=(64, 36)),
    )
    (tmp_path / "saved.toml").write_text(text)
    again = load_scene(tmp_path / "saved.toml")
    names = (*EDITED, "blends")
    for saved, shown in zip(again.materials, edited.materials, strict=True):
        assert [getattr(saved, n) for n in names] == [getattr(shown, n) for n in names]
    assert again.materials[index].is_translucent


def test_what_a_lamp_emits_is_up_to_its_light(room: Scene, tmp_path: Path) -> None:
    index = next(item.material for item in room.objects if item.light is not None)
    path = tmp_path / "mine.toml"
    path.write_text(f'base="cornell_meso"\n[[edit]]\nmaterial={index + 1}\nemission=[1,1,1]')
    with pytest.raises(SceneError, match="expected an edit of the light"):
        load_scene(path)


def test_only_one_that_becomes_clearer_shows_what_is_behind() -> None:
    cut = Material(alpha=0.9, alpha_cutoff=0.5)
    assert not edited_material(cut, {"albedo": (1.0, 0.0, 0.0)}).blends
    assert edited_material(cut, {"alpha": 0.5}).blends
    assert not edited_material(Material(), {"alpha": 1.0}).blends


def test_pointing_finds_the_surface_that_is_nearest(room: Scene) -> None:
    for item in room.objects:
        mesh, matrix = room.meshes[item.mesh], item.world_from_object[0]
        middle = mesh.positions[mesh.triangles[0]].mean(axis=0) @ matrix[:3, :3].T + matrix[:3, 3]
        # A little off, as a depth buffer has it.
        point = tuple(float(x) for x in middle + 1e-5)
        assert material_at(room, point) == item.material
    assert material_at(room, (90.0, 0.0, 0.0)) is None


def test_a_change_of_shading_builds_no_hierarchy_and_draws_what_a_new_start_does(
    gl, device, shaders, room: Scene
) -> None:
    index = wall(room)
    values = {"albedo": (0.1, 0.7, 0.3), "emission": (0.0, 0.1, 0.4)}
    edited = with_edited(room, index, edited_material(room.materials[index], values))
    settings = Settings("gi", size=(24, 16), samples=4, steps=4)
    with Renderer(room, settings, device=device, shaders=shaders) as renderer:
        before = renderer.render().images["beauty"]
        renderer.use_scene(edited)
        changed = renderer.render()
    with Renderer(edited, settings, device=device, shaders=shaders) as renderer:
        fresh = renderer.render().images["beauty"]
    assert np.abs(changed.images["beauty"] - before).mean() > 0.01
    assert np.array_equal(changed.images["beauty"], fresh)
    ran = {row.name for row in changed.passes if row.ran}
    assert {"gbuffer", "material_table", "surface_cache"} <= ran
    assert not {"bvh_upload", "surface_tables", "surfels", "shadow_map"} & ran
