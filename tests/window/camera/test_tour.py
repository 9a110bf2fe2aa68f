"""Bookmarks and paths of a viewer: kept, recalled, recorded and played."""

from __future__ import annotations

import numpy as np
import pytest
from window.driven_viewer import FORWARD, FRAME_S, SIZE, ask, said, settle

from ssdo_gl.window.camera import Controls
from ssdo_gl.window.input.bindings import Command


def test_bookmarks_are_kept_and_recalled(gl, viewer, make_viewer) -> None:
    for _ in range(10):
        viewer.frame(FORWARD, FRAME_S, SIZE)
    settle(viewer)
    place = viewer.camera.position
    ask(viewer, Command.STORE, 3)
    other = make_viewer()
    assert other.tour.numbers == [3]
    ask(other, Command.RECALL, 3)
    settle(other)
    assert other.camera.position == pytest.approx(place, abs=1e-5)
    ask(other, Command.RECALL, 4)
    assert "no bookmark 4" in said(other)


def test_path_is_recorded_played_and_kept(gl, viewer, make_viewer) -> None:
    ask(viewer, Command.RECORD)
    for _ in range(30):
        viewer.frame(FORWARD, FRAME_S, SIZE)
    ask(viewer, Command.RECORD)
    end = viewer.camera.position
    assert viewer.tour.path.seconds == pytest.approx(1.0, abs=0.15)
    other = make_viewer()
    ask(other, Command.PLAY)
    other.frame(Controls(), 0.0, SIZE)
    assert other.camera.position == pytest.approx(viewer.scene.camera.position)
    for _ in range(40):
        other.frame(Controls(), FRAME_S, SIZE)
    assert other.tour.played_s is None
    # Keys are a tenth of a second apart: the end may be cut by as much.
    assert np.linalg.norm(np.subtract(other.camera.position, end)) < 0.1
    settle(other)


def test_input_takes_over_from_a_playing_path(gl, viewer) -> None:
    ask(viewer, Command.RECORD)
    for _ in range(20):
        viewer.frame(FORWARD, FRAME_S, SIZE)
    ask(viewer, Command.RECORD)
    ask(viewer, Command.PLAY)
    for _ in range(5):
        viewer.frame(Controls(), FRAME_S, SIZE)
    there = viewer.camera.position
    viewer.frame(Controls(move=(1.0, 0.0, 0.0)), FRAME_S, SIZE)
    assert viewer.tour.played_s is None
    assert np.linalg.norm(np.subtract(viewer.camera.position, there)) < 0.1


def test_play_without_a_path_says_so(viewer) -> None:
    ask(viewer, Command.PLAY)
    assert "record one" in said(viewer)
    assert viewer.tour.played_s is None


KEY = "[0, 0, 0, 3, 0, 0, -1, 1, 40]"


@pytest.mark.parametrize(
    "text",
    [
        "nonsense",
        "[" * 100_000,
        "[]",
        '{"bookmarks": []}',
        '{"bookmarks": {"1": {"position": [0, 0, 0], "target": [0, 0, -1], "fov_y": 0}}}',
        '{"bookmarks": {"1": {"position": [1e300, 0, 0], "target": [0, 1, 0], "fov_y": 9}}}',
        '{"bookmarks": {"1": {"position": [1e17, 0, 0], "target": [1e17, 0, 9], "fov_y": 9}}}',
        '{"bookmarks": {"1": {"position": [%s, 0, 0], "target": [0, 0, 9], "fov_y": 40}}}'
        % ("9" * 400),
        '{"bookmarks": {"1": 5}}',
        '{"path": 5}',
        '{"path": [[%s, 0, 0, 3, 0, 0, -1, 1, 40]]}' % ("9" * 400),
        '{"path": [[0, 1e300, 0, 3, 0, 0, -1, 1, 40]]}',
        '{"path": [[0, 0, 0, 3, 0, 0, 0, 1, 40]]}',
        f'{{"path": [{KEY}, {KEY}]}}',
        f'{{"path": [{KEY.replace("40", "NaN")}]}}',
    ],
)
def test_views_file_that_is_damaged_is_a_message_and_kept(
    gl, make_viewer, tmp_path, text: str
) -> None:
    file = tmp_path / "cornell_meso.views.json"
    file.write_text(text)
    viewer = make_viewer()
    assert "views.json" in said(viewer)
    viewer.frame(Controls(), FRAME_S, SIZE)
    ask(viewer, Command.STORE, 1)
    assert "move it away" in said(viewer)
    assert file.read_text() == text
