"""What is drawn of a glTF file's nodes and primitives, and what is named instead."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from glb_writer import GlbWriter

from ssdo_gl import Renderer, Settings
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.scene.scene_error import SceneError


def load(glb: GlbWriter, folder: Path) -> Scene:
    return load_scene(glb.save(folder / "a.glb"))


@pytest.mark.parametrize(
    ("scale", "front"), [((1, 1, 0), 1.0), ((-1, 1, 0), -1.0), ((-1, -1, 0), 1.0)]
)
def test_a_flattened_node_shows_and_keeps_its_front(
    scale: tuple[int, int, int], front: float, glb: GlbWriter, tmp_path: Path
) -> None:
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    glb.json["nodes"][0] = {"mesh": 0, "scale": list(scale), "translation": [0, 0, 7]}
    scene = load(glb, tmp_path)
    (item,) = scene.objects
    mesh, matrix = scene.meshes[item.mesh], item.world_from_object[0]
    corners = mesh.positions[mesh.triangles[0]] @ matrix[:3, :3].T + matrix[:3, 3]
    expected = np.array([[0, 0, 7], [scale[0], 0, 7], [0, scale[1], 7]])
    assert sorted(corners.tolist()) == pytest.approx(np.array(sorted(expected.tolist())))
    assert np.sign(np.cross(corners[1] - corners[0], corners[2] - corners[0])[2]) == front
    assert np.linalg.det(matrix[:3, :3]) > 0.0


def test_a_node_scaled_to_a_line_is_left_out(glb: GlbWriter, tmp_path: Path) -> None:
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    glb.json["nodes"] = [{"mesh": 0}, {"mesh": 0, "scale": [1, 0, 0]}]
    glb.json["scenes"] = [{"nodes": [0, 1]}]
    scene = load(glb, tmp_path)
    assert scene.triangle_count == 1
    assert "instances scaled to zero size dropped" in scene.notes


@pytest.mark.parametrize("scale", [[0, 1, 1], [1, 0, 1]])
@pytest.mark.parametrize("turn", [[0, 0, 0, 1], [0.5, 0.5, 0.5, 0.5]])
def test_a_panel_flattened_edge_on_is_left_out(
    scale: list[int], turn: list[float], glb: GlbWriter, tmp_path: Path
) -> None:
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    glb.json["nodes"] = [{"mesh": 0}, {"mesh": 0, "scale": scale, "rotation": turn}]
    glb.json["scenes"] = [{"nodes": [0, 1]}]
    scene = load(glb, tmp_path)
    assert scene.triangle_count == 1
    assert "instances scaled to zero size dropped" in scene.notes


def test_hidden_nodes_hide_what_hangs_on_them(glb: GlbWriter, tmp_path: Path) -> None:
    hidden = {"KHR_node_visibility": {"visible": False}}
    shown = {"KHR_node_visibility": {"visible": True}}
    glb.json["extensionsRequired"] = ["KHR_node_visibility"]
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    glb.json["nodes"] = [
        {"mesh": 0, "extensions": shown},
        {"mesh": 0, "extensions": hidden, "children": [2]},
        {"mesh": 0, "extensions": shown, "translation": [0, 5, 0]},
    ]
    glb.json["scenes"] = [{"nodes": [0, 1]}]
    (item,) = load(glb, tmp_path).objects
    assert item.world_from_object[:, :3, 3].tolist() == [[0.0, 0.0, 0.0]]


@pytest.mark.parametrize("mode", [1, 2, 3])
def test_lines_are_named(mode: int, glb: GlbWriter, tmp_path: Path) -> None:
    primitive: dict[str, Any] = glb.triangle()
    glb.json["meshes"] = [{"primitives": [primitive, {**primitive, "mode": mode}]}]
    assert "1 primitives of lines are not drawn" in load(glb, tmp_path).notes
    glb.json["meshes"] = [{"primitives": [{**primitive, "mode": mode}] * 2}]
    with pytest.raises(SceneError, match=r"no triangle with an area .2 primitives of lines"):
        load(glb, tmp_path)


def test_geometry_is_not_averaged_with_what_lies_behind(glb: GlbWriter, tmp_path: Path) -> None:
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    scene = load(glb, tmp_path)
    names = ("depth", "normal_ws", "position_ws", "albedo")
    images = {}
    for count in (1, 4):
        with Renderer(scene, Settings(size=(40, 24), antialias=count)) as renderer:
            images[count] = renderer.render(names).images
    for name in names[:3]:
        assert np.array_equal(images[1][name], images[4][name])
    # Colours are averaged: along the edges they lie between surface and background.
    between = (images[4]["albedo"] > 0.0) & (images[4]["albedo"] < images[1]["albedo"].max())
    assert between.any()


@pytest.mark.parametrize(
    ("chosen", "note"),
    [
        (0, "drawn is the file's scene a, without: b, c"),
        (2, "drawn is the file's scene c, without: a, b"),
    ],
)
def test_other_scenes_of_a_file_are_named(chosen, note, glb, tmp_path: Path) -> None:
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    glb.json["nodes"] = [{"mesh": 0, "translation": [x, 0, 0]} for x in (0, 5, 9)]
    glb.json["scenes"] = [{"name": name, "nodes": [i]} for i, name in enumerate("abc")]
    glb.json["scene"] = chosen
    scene = load(glb, tmp_path)
    assert note in scene.notes
    assert scene.bounds()[0][0] == (0, 5, 9)[chosen]
    for index in range(3):
        if index != chosen:
            glb.json["scenes"][index]["nodes"] = []
    assert not any("drawn is" in text for text in load(glb, tmp_path).notes)


@pytest.mark.parametrize("mode", [4, 5, 6])
def test_a_primitive_without_vertices_is_left_out(
    mode: int, glb: GlbWriter, tmp_path: Path
) -> None:
    empty = glb.accessor(np.zeros((0, 3), dtype="<f4"), "VEC3")
    primitives = [{"mode": mode, "attributes": {"POSITION": empty}}, glb.triangle()]
    glb.json["meshes"] = [{"primitives": primitives}]
    assert load(glb, tmp_path).triangle_count == 1
