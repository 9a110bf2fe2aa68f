"""Cameras of glTF files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from glb_writer import load

from ssdo_gl.image_requests import asked_scene
from ssdo_gl.scene.scene_error import SceneError


def test_the_camera_of_the_file_is_used(glb, tmp_path: Path) -> None:
    glb.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 1}}]
    glb.json["scenes"] = [{"nodes": [0, 1]}]
    glb.json["nodes"] = [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 8]}]
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    camera = load(glb, tmp_path).camera
    assert camera.position == (0, 0, 8)
    assert np.radians(camera.fov_y) == pytest.approx(0.5)
    forward = np.subtract(camera.target, camera.position)
    assert forward / np.linalg.norm(forward) == pytest.approx([0, 0, -1])
    # The pivot lies level with the scene.
    assert camera.target[2] == pytest.approx(0.0)


@pytest.mark.parametrize("size", [2.5, -2.5])
def test_a_camera_of_parallel_rays_is_used(glb, tmp_path: Path, size: float) -> None:
    """`ymag` is half the height; negative ones are out of use and mean the same."""
    shape = {"xmag": 4, "ymag": size, "znear": 0, "zfar": 9}
    glb.json["cameras"] = [{"type": "orthographic", "orthographic": shape}]
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    glb.json["nodes"] = [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 8]}]
    glb.json["scenes"] = [{"nodes": [0, 1]}]
    scene = load(glb, tmp_path)
    assert (scene.camera.position, scene.camera.height) == ((0, 0, 8), 5.0)
    assert not any("camera" in note for note in scene.notes)


@pytest.mark.parametrize(
    ("camera", "node", "fault"),
    [
        ({"type": "orthographic", "orthographic": {"ymag": 0}}, {}, "ymag = 0: expected"),
        ({"type": "orthographic", "orthographic": {"ymag": 1e30}}, {}, "ymag = 1e+30: expected"),
        ({"type": "perspective", "perspective": {"yfov": 0}}, {}, "yfov = 0 degrees"),
        ({"type": "perspective", "perspective": {"yfov": 3.2}}, {}, "yfov = 183.346 degrees"),
        (
            {"type": "perspective", "perspective": {"yfov": 1}},
            {"scale": [0, 1, 0]},
            "its node is scaled to zero",
        ),
    ],
)
def test_a_camera_that_sees_nothing_is_left_out(
    camera, node, fault: str, glb, tmp_path: Path
) -> None:
    glb.json["cameras"] = [camera, {"type": "perspective", "perspective": {"yfov": 0.5}}]
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    glb.json["nodes"] = [{"mesh": 0}, {"camera": 0, "name": "bad", **node}]
    glb.json["scenes"] = [{"nodes": [0, 1]}]
    scene = load(glb, tmp_path)
    assert scene.is_framed
    assert any(f"camera bad dropped: {fault}" in note for note in scene.notes)
    glb.json["nodes"].append({"camera": 1, "translation": [0, 0, 8]})
    glb.json["scenes"] = [{"nodes": [0, 1, 2]}]
    assert load(glb, tmp_path).camera.position == (0, 0, 8)


def test_a_camera_without_a_number_is_refused(glb, tmp_path: Path) -> None:
    glb.json["cameras"] = [{"type": "orthographic", "orthographic": {"ymag": "a"}}]
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    glb.json["nodes"] = [{"mesh": 0}, {"camera": 0}]
    glb.json["scenes"] = [{"nodes": [0, 1]}]
    with pytest.raises(SceneError, match="ymag"):
        load(glb, tmp_path)


def test_a_camera_may_be_numbered_by_any_kind_of_whole_number(glb, tmp_path: Path) -> None:
    lens = {"type": "perspective", "perspective": {"yfov": 0.5}}
    glb.json["cameras"] = [lens, {**lens, "perspective": {"yfov": 1.0}}]
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    glb.json["nodes"] = [{"mesh": 0}, *({"camera": n, "translation": [0, 0, 8]} for n in (0, 1))]
    glb.json["scenes"] = [{"nodes": [0, 1, 2]}]
    path = glb.save(tmp_path / "a.glb")
    scene, place, _ = asked_scene(path, np.int64(1), {})
    assert np.radians(scene.camera.fov_y) == pytest.approx(1.0) and place is None
