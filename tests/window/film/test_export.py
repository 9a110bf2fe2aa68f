"""A film of the path that was recorded in a viewer."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from PIL import Image
from window.driven_viewer import FORWARD, FRAME_S, SIZE, ask, said

from ssdo_gl.film.camera_path import CameraPath
from ssdo_gl.images.display import picture_of
from ssdo_gl.options.run_options import FRAMES_PER_SECOND
from ssdo_gl.renderer import Renderer
from ssdo_gl.window.camera import Controls
from ssdo_gl.window.film.export import ANTIALIAS, FilmExport, Interrupted
from ssdo_gl.window.input.bindings import Command


@pytest.mark.parametrize("suffix", [".webp", ".png"])
def test_film_of_the_path_in_each_format(gl, viewer, tmp_path, suffix: str) -> None:
    viewer.choose_method("direct")
    viewer.frame(Controls(), FRAME_S, SIZE)
    films = FilmExport(viewer)
    films.toggle()
    assert not films.is_busy
    assert "record one" in said(viewer)
    ask(viewer, Command.RECORD)
    for _ in range(6):
        viewer.frame(FORWARD, FRAME_S, SIZE)
    ask(viewer, Command.RECORD)
    viewer.film_suffix = suffix
    films.toggle()
    size, seen = viewer.picture_size, []
    while films.step():
        seen.append(viewer.presenter.pixels())
        assert "wrote" in said(viewer) or " left" in said(viewer)
    assert "wrote" in said(viewer)
    assert viewer.picture_size == size == seen[0].shape[1::-1]
    assert not np.array_equal(seen[0], seen[-1])
    if suffix == ".png":
        with Image.open(sorted((tmp_path / "cornell_meso-001").iterdir())[0]) as first:
            assert np.array_equal(np.asarray(first)[:, :, :3], seen[0])
    viewer.frame(Controls(), FRAME_S, SIZE)
    assert not np.array_equal(viewer.presenter.pixels(), seen[-1])
    made = {path.name for path in tmp_path.iterdir() if "views" not in path.name}
    assert made == {"cornell_meso-001.webp" if suffix == ".webp" else "cornell_meso-001"}
    films.toggle()
    films.step()
    films.toggle()
    assert not films.is_busy
    assert {path.name for path in tmp_path.iterdir() if "views" not in path.name} == made


def begun(viewer) -> FilmExport:
    """Return a film of a short path, in the making."""
    viewer.choose_method("direct")
    viewer.frame(Controls(), FRAME_S, SIZE)
    camera = viewer.scene.camera
    moved = dataclasses.replace(camera, position=(0.3, 0.1, 3.0))
    viewer.tour._views.path = CameraPath().recorded(0.0, camera).recorded(0.2, moved)
    viewer.film_suffix = ".png"
    films = FilmExport(viewer)
    films.toggle()
    return films


def test_frames_are_those_of_snapshots(gl, viewer, tmp_path) -> None:
    films = begun(viewer)
    while films.step():
        pass
    settings = dataclasses.replace(
        viewer.settings_of_side(0), size=viewer.picture_size, antialias=ANTIALIAS
    )
    with Renderer(viewer.scene, settings, device=viewer.device) as renderer:
        camera = viewer.tour.path.camera(3 / FRAMES_PER_SECOND, viewer.scene.camera)
        display = renderer.render(["display"], camera=camera).images["display"]
    with Image.open(tmp_path / "cornell_meso-001" / "0004.png") as image:
        assert np.array_equal(np.asarray(image), picture_of("display", display)[:, :, :3])


def test_input_gives_a_film_up_and_leaves_no_trace(gl, viewer, tmp_path) -> None:
    def interrupt(what: str, done: int, total: int) -> None:
        raise Interrupted

    films = begun(viewer)
    assert films.step()
    assert films.step(interrupt)
    assert not films.is_busy
    assert "given up" in said(viewer)
    assert not [path for path in tmp_path.iterdir() if "views" not in path.name]
