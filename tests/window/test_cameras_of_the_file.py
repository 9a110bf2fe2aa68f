"""The key that goes through the cameras of a model file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from glb_writer import GlbWriter
from window.driven_viewer import ask, said

from ssdo_gl.window.input import Command
from ssdo_gl.window.opening import open_file

NAMES = ("Front", "Side", "")


@pytest.fixture
def path(tmp_path: Path) -> str:
    glb = GlbWriter()
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    glb.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 1}}]
    nodes = [
        {"camera": 0, "name": name, "translation": [0, 0, 4 + i]} for i, name in enumerate(NAMES)
    ]
    glb.json["nodes"] = [{"mesh": 0}, *nodes]
    glb.json["scenes"] = [{"nodes": [0, 1, 2, 3]}]
    times = glb.accessor(np.array([0, 1], dtype="<f4"), "SCALAR")
    places = glb.accessor(np.array([[0, 0, 5], [8, 0, 5]], dtype="<f4"), "VEC3")
    channel = {"sampler": 0, "target": {"node": 2, "path": "translation"}}
    glb.json["animations"] = [
        {"samplers": [{"input": times, "output": places}], "channels": [channel]}
    ]
    return str(glb.save(tmp_path / "a.glb"))


def test_they_follow_each_other(gl, make_viewer, path: str) -> None:
    viewer = make_viewer(path)
    places = []
    for _ in range(4):
        ask(viewer, Command.NEXT_CAMERA)
        places.append(viewer.camera.position[2])
    assert places == [5, 6, 4, 5]
    assert "camera 1: Side" in said(viewer)


def test_one_that_moves_stands_as_at_that_time(gl, make_viewer, path: str) -> None:
    viewer = make_viewer(path)
    viewer.clock.seconds = 0.25
    ask(viewer, Command.NEXT_CAMERA)
    assert viewer.camera.position == pytest.approx((2, 0, 5))


def test_the_first_press_goes_on_from_the_camera_that_was_asked_for(
    gl, make_viewer, path: str
) -> None:
    viewer = make_viewer(path, camera="Side")
    ask(viewer, Command.NEXT_CAMERA)
    assert viewer.camera.position == (0, 0, 6)
    assert "camera 2: without a name" in said(viewer)


def test_without_any_it_says_so(gl, viewer) -> None:
    before = viewer.camera
    ask(viewer, Command.NEXT_CAMERA)
    assert viewer.camera == before
    assert "the file has no camera of its own" in said(viewer)


def test_another_file_is_not_asked_for_the_camera_of_this_one(
    gl, make_viewer, path: str, tmp_path: Path
) -> None:
    viewer = make_viewer(path, camera="Side")
    glb = GlbWriter()
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    assert open_file(str(glb.save(tmp_path / "b.glb")), viewer)
    assert open_file(path, viewer)
    assert viewer.camera.position == (0, 0, 4)
