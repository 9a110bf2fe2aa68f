"""The key that goes through the cameras of a model file."""

from __future__ import annotations

from pathlib import Path

import pytest
from glb_writer import GlbWriter, save_with_cameras
from window.driven_viewer import ask, said

from ssdo_gl.window.input import Command
from ssdo_gl.window.opening import open_file

NAMES = ("Front", "Side", "")


@pytest.fixture
def path(tmp_path: Path) -> str:
    return str(save_with_cameras(tmp_path / "a.glb", NAMES))


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
