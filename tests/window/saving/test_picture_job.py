"""Pictures of any size and method, rendered beside the window."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from window.driven_viewer import settle
from window.x_server import wait_for

from ssdo_gl.window.saving.picture_job import PictureJob
from ssdo_gl.window.viewer import Viewer

SIZE = (40, 24)


@pytest.fixture
def viewer(make_viewer, tmp_path: Path) -> Viewer:
    # The picture is made by a command that finds the file by its name.
    source = tmp_path / "tile.toml"
    source.write_text(
        '[camera]\nposition = [0, 0, 6]\ntarget = [0, 0, 0]\n[[light]]\nkind = "point"\n'
        "position = [0, 1, 3]\nintensity = [9, 9, 9]\n"
        '[[object]]\nshape = "plane"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nsize = 2\n'
    )
    viewer = make_viewer(str(source))
    settle(viewer)
    return viewer


def said(viewer: Viewer) -> str:
    return viewer.messages.lines[-1].text


def test_a_picture_has_the_size_method_and_background_asked_for(gl, viewer, tmp_path) -> None:
    job = PictureJob(viewer)
    request = job.usual_request()
    assert request.name == "picture-001.png"
    assert request.method == viewer.view.method
    # Brighter than its file has it: the edited scene is rendered.
    viewer.lights[0] = viewer.lights[0].with_emitted((20.0, 0.0, 0.0))
    viewer.apply_lights()
    job.start(dataclasses.replace(request, size=SIZE, method="direct", is_transparent=True))
    job.start(request)
    assert said(viewer) == "wait for picture-001.png"
    wait_for("the picture is written", job.poll)
    assert said(viewer) == "wrote picture-001.png"
    with Image.open(tmp_path / request.name) as image:
        pixels = np.asarray(image)
    assert pixels.shape == (SIZE[1], SIZE[0], 4)
    assert pixels[0, 0, 3] == 0
    red, green, _, alpha = pixels[SIZE[1] // 2, SIZE[0] // 2]
    assert alpha == 255
    assert red > 50
    assert green == 0
    job.start(request)
    assert "exists" in said(viewer)


def test_what_goes_wrong_with_a_picture_is_told(gl, viewer, tmp_path) -> None:
    job = PictureJob(viewer)
    job.start(dataclasses.replace(job.usual_request(), size=SIZE, name="picture.gif"))
    wait_for("the command ends", job.poll)
    assert "picture.gif" in said(viewer)
    assert ".png" in said(viewer)
    assert viewer.messages.lines[-1].is_fault
    job.start(dataclasses.replace(job.usual_request(), size=(4000, 4000), name="large.png"))
    job.give_up()
    assert not (tmp_path / "large.png").exists()
