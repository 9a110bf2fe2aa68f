"""A film of the path that was recorded in a viewer."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image
from window.driven_viewer import FORWARD, FRAME_S, SIZE, ask, said

from ssdo_gl.window.camera import Controls
from ssdo_gl.window.film.export import FilmExport
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
