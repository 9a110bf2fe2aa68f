"""A path through recorded keys, and the file that keeps it."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

from ssdo_gl.film.bookmarks import (
    Views,
    ViewsFileError,
    load_path,
    load_views,
    save_views,
    views_file,
)
from ssdo_gl.film.camera_path import KEYS_PER_SECOND, CameraPath
from ssdo_gl.scene.camera import Camera
from ssdo_gl.settings.fields import SettingError

BASE = Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), fov_y=40.0, exposure=0.5)
# A circle recorded every 0.10 to 0.11 s: tangents are short by angle^2 / 6 (0.22 rad per
# key), an eighth of a stretch of which reaches the middle: 2e-4 of the radius.
CIRCLE_TOLERANCE = 2.5e-4
RATE = 2.0  # radians per second


def on_circle(seconds: float) -> Camera:
    angle = RATE * seconds
    position = (math.cos(angle), 0.2, math.sin(angle))
    return Camera(position, (0.0, 0.2, 0.0), fov_y=40.0)


def circle() -> CameraPath:
    path = CameraPath()
    for frame in range(300):
        path = path.recorded(frame / 100, on_circle(frame / 100))
    return path


def test_recording_keeps_ten_keys_a_second() -> None:
    assert len(circle().keys) == pytest.approx(3.0 * KEYS_PER_SECOND, abs=1)


def test_path_goes_through_its_keys() -> None:
    path = circle()
    for key in path.keys:
        camera = path.camera(key.seconds, BASE)
        np.testing.assert_allclose(camera.position, key.position, atol=1e-12)
        np.testing.assert_allclose(camera.target, (0.0, 0.2, 0.0), atol=1e-12)


def test_path_restores_what_lay_between_the_keys() -> None:
    path = circle()
    # The first and the last stretch have one-sided tangents, which are less exact.
    for seconds in np.linspace(0.15, path.seconds - 0.15, 200):
        camera, exact = path.camera(float(seconds), BASE), on_circle(float(seconds))
        np.testing.assert_allclose(camera.position, exact.position, atol=CIRCLE_TOLERANCE)
        np.testing.assert_allclose(camera.target, exact.target, atol=CIRCLE_TOLERANCE)


def test_speed_does_not_jump_at_a_key() -> None:
    path = circle()
    step = 1e-6
    for key in path.keys[1:-1]:
        a, b, c = (
            np.array(path.camera(key.seconds + d, BASE).position) for d in (-step, 0.0, step)
        )
        np.testing.assert_allclose((b - a) / step, (c - b) / step, atol=1e-3)


def test_ends_are_held_and_the_rest_comes_from_the_base() -> None:
    path = circle()
    assert path.camera(-1.0, BASE).position == pytest.approx(path.keys[0].position)
    late = path.camera(99.0, BASE)
    assert late.position == pytest.approx(path.keys[-1].position)
    assert (late.exposure, late.up) == (BASE.exposure, BASE.up)
    assert CameraPath().camera(1.0, BASE) is BASE
    single = CameraPath().recorded(0.0, on_circle(0.0))
    assert single.camera(0.7, BASE).position == pytest.approx(on_circle(0.0).position)


def test_field_of_view_does_not_overshoot() -> None:
    path = CameraPath()
    for seconds, fov in ((0.0, 10.0), (1.0, 10.0), (1.1, 170.0), (3.0, 170.0)):
        path = path.recorded(seconds, Camera((0, 0, seconds), (0, 0, -9), fov_y=fov))
    fovs = [path.camera(float(t), BASE).fov_y for t in np.linspace(0.0, 3.0, 301)]
    assert min(fovs) == 10.0
    assert max(fovs) == 170.0


def test_turning_around_on_the_spot_stays_a_direction() -> None:
    path = CameraPath()
    path = path.recorded(0.0, Camera((0, 0, 0), (0, 0, -1)))
    path = path.recorded(1.0, Camera((0, 0, 0), (0, 0, 1)))
    camera = path.camera(0.5, BASE)
    assert math.dist(camera.position, camera.target) == pytest.approx(1.0)


def test_file_gives_back_what_was_saved(tmp_path: Path) -> None:
    file = views_file("scenes/room.toml", tmp_path)
    assert file == tmp_path / "room.views.json"
    assert load_views(file, BASE) == Views()
    views = Views({1: on_circle(0.1), 9: on_circle(0.2)}, circle())
    save_views(file, views)
    read = load_views(file, BASE)
    assert set(read.cameras) == {1, 9}
    assert read.cameras[9].position == on_circle(0.2).position
    assert read.cameras[9].exposure == BASE.exposure
    np.testing.assert_allclose(read.path.to_data(), views.path.to_data(), rtol=1e-15)


def test_parallel_rays_are_kept_and_followed(tmp_path: Path) -> None:
    near, far = (on_circle(t).orthographic(h) for t, h in ((0.0, 2.0), (1.0, 6.0)))
    path = CameraPath().recorded(0.0, near).recorded(1.0, far)
    file = views_file("room", tmp_path)
    save_views(file, Views({1: far}, path))
    read = load_views(file, BASE)
    assert read.cameras[1].height == 6.0
    assert [read.path.camera(t, BASE).height for t in (0.0, 0.5, 1.0)] == pytest.approx([2, 4, 6])


def test_between_a_pinhole_and_parallel_rays_the_path_jumps() -> None:
    path = (
        CameraPath().recorded(0.0, on_circle(0.0)).recorded(1.0, on_circle(1.0).orthographic(6.0))
    )
    path = path.recorded(2.0, on_circle(2.0))
    heights = [path.camera(t, BASE).height for t in (0.0, 0.5, 0.9, 1.0, 1.5, 2.0)]
    assert heights[:3] == [None] * 3 and heights[-1] is None
    assert heights[3] == heights[4] == 6.0


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "nonsense",
        '{"bookmarks": [1]}',
        '{"bookmarks": 2}',
        '{"bookmarks": {"1": 3}}',
        '{"path": 1}',
        '{"path": [1]}',
        '{"path": [["a"]]}',
        '{"path": [[[1]]]}',
        '{"bookmarks": {"1": {"position": "abc", "target": 1, "fov_y": []}}}',
        '{"path": [[0, 0, 0, 0, 0, 0, -1, 1, 1%s]]}' % ("0" * 400),
        '{"bookmarks": {"1": {"position": [0, 0, 0]}}}',
        '{"bookmarks": {"1": {"position": [0, 0, 0], "target": [0, 0, 0], "fov_y": 40}}}',
        '{"bookmarks": {"1": {"position": [0, 0], "target": [0, 0, 1], "fov_y": 40}}}',
        '{"bookmarks": {"x": {"position": [0, 0, 0], "target": [0, 0, 1], "fov_y": 40}}}',
        '{"path": [[0, 0, 0, 0]]}',
        '{"path": {"0": 1}}',
        json.dumps({"path": [[0, 0, 0, 0, 0, 0, 0, 1, 40]]}),
        json.dumps({"path": [[0, 0, 0, 0, 0, 0, -1, 1, 40]] * 2}),
        json.dumps({"path": [[0, 0, 0, 0, 0, 0, -1, 1, 400]]}),
        '{"path": [[0, 0, 0, 0, 0, 0, -1, NaN, 40]]}',
        '{"path": [[0, 0, 0, 0, 0, 0, -1, 1, 40, -2]]}',
        '{"path": [[0, 0, 0, 0, 0, 0, -1, 1, 40, 2, 2]]}',
        '{"bookmarks": {"1": {"position": [0,0,0], "target": [0,0,1], "fov_y": 40, "height": 0}}}',
    ],
)
def test_broken_files_are_named_in_one_line(tmp_path: Path, text: str) -> None:
    file = tmp_path / "room.views.json"
    file.write_text(text)
    with pytest.raises(ViewsFileError, match=r"room\.views\.json") as caught:
        load_views(file, BASE)
    said = str(caught.value)
    assert "\n" not in said
    # What Python raised over it helps nobody.
    assert not re.search(r"object|attribute|argument|literal|iterable|unpack", said)


def test_a_path_that_no_system_can_hold_is_named_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(SettingError, match="no such file; a window records one with L"):
        load_path(tmp_path / ("n" * 5000))
