"""Cameras: what they refuse, the ways to place them, and files with several."""

from __future__ import annotations

import doctest
import math
from pathlib import Path

import numpy as np
import pytest
from glb_writer import GlbWriter, save_with_cameras

import ssdo_gl
import ssdo_gl.scene.camera
from ssdo_gl.scene.animate import scene_at
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.defaults.framing import MARGIN
from ssdo_gl.scene.geometry.topology import placed
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene_error import SceneError
from ssdo_gl.settings.fields import SettingError

# Angles and lengths in float64.
EXACT = 1e-12


def test_the_documented_example_runs():
    results = doctest.testmod(ssdo_gl.scene.camera)
    assert results.attempted >= 2 and results.failed == 0


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"target": (0, 0, 4)}, "target = .*: expected another point than position"),
        ({"position": (0, math.nan, 4)}, "position = .*: expected finite numbers"),
        ({"position": "here"}, "position = 'here': expected three numbers"),
        ({"target": (1, 2)}, "target = .*: expected three numbers"),
        ({"up": (0, 0, 0)}, "up = .*: expected a direction"),
        ({"fov_y": 180.0}, "fov_y = 180.0: expected degrees between 0 and 180"),
        ({"height": 0.0}, "height = 0.0: expected scene units above 0"),
        ({"fov_y": "35"}, "fov_y = .35.: expected a finite number"),
        ({"exposure": math.nan}, "exposure = nan: expected a finite number"),
        ({"height": math.inf}, "height = inf: expected a finite number"),
        ({"position": (0, 0, 1e31)}, "position = .*: expected at most 1e.30 in size"),
        ({"exposure": -1e31}, "exposure = -1e.31: expected at most 1e.30 in size"),
    ],
)
def test_a_camera_without_a_picture_is_refused(fields, message):
    with pytest.raises(SettingError, match=message):
        Camera(**{"position": (0, 0, 4), "target": (0, 0, 0), **fields})


@pytest.mark.parametrize(
    ("height", "near", "far", "message"),
    [
        (None, 0.0, 1.0, "near = 0.0, far = 1.0: expected 0 < near < far"),
        (None, 1.0, 1.0, "near = 1.0, far = 1.0: expected 0 < near < far"),
        (None, 1.0, math.inf, "far = inf: expected a finite number"),
        (None, "a", 1.0, "near = 'a': expected a finite number"),
        (2.0, 1.0, -1.0, "near = 1.0, far = -1.0: expected near < far"),
    ],
)
def test_a_projection_needs_one_depth_beyond_the_other(height, near, far, message):
    camera = Camera((0, 0, 4), (0, 0, 0), height=height)
    with pytest.raises(SettingError, match=message):
        camera.projection((16, 9), near, far)


@pytest.mark.parametrize("size", [(0, 0), (16, 0), (-1, 3), (4.5, 3), (4,), 3, "ab", None])
def test_a_picture_without_pixels_is_refused(size):
    camera = Camera((0, 0, 4), (0, 0, 0))
    with pytest.raises(SettingError, match=r"size = .*: expected two whole numbers from 1 on"):
        camera.intrinsics(size)
    with pytest.raises(SettingError, match=r"size = .*: expected two whole numbers from 1 on"):
        camera.projection(size, 1.0, 2.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda c: c.orbit("a"), "degrees = 'a': expected a finite number"),
        (lambda c: c.orbit(1.0, None), "up_degrees = None: expected a finite number"),
        (lambda c: c.orthographic(0), "height = 0: expected scene units above 0"),
        (lambda c: Camera.from_pose("a"), "world_from_camera: expected a rotation"),
        (lambda c: Camera.from_pose([[1], [1, 2]]), "world_from_camera: expected a rotation"),
    ],
)
def test_a_turn_without_meaning_is_refused(change, message):
    with pytest.raises(SettingError, match=message):
        change(Camera((0, 0, 4), (0, 0, 0)))


@pytest.mark.parametrize(
    ("scene", "fields", "message"),
    [
        (3, {}, "scene: expected a Scene, got an int"),
        ("corner", {}, "scene: expected a Scene, got a str"),
        (None, {"direction": (0, 0, 0)}, "direction = .*: expected a direction"),
        (None, {"direction": 3}, "direction = 3: expected three numbers"),
        (None, {"fov_y": 0}, "fov_y = 0: expected degrees between 0 and 180"),
        (None, {"fov_y": "a"}, "fov_y = 'a': expected a finite number"),
    ],
)
def test_fit_refuses_what_it_cannot_frame(scene, fields, message):
    scene = ssdo_gl.load_scene("corner") if scene is None else scene
    with pytest.raises((SettingError, SceneError), match=message):
        Camera.fit(scene, **fields)


def test_points_may_be_arrays():
    camera = Camera.look_at(np.array([0, 0, 4]), [0, 1, 0], fov_y=30.0)
    assert camera == Camera((0.0, 0.0, 4.0), (0.0, 1.0, 0.0), fov_y=30.0)
    assert hash(camera) == hash(Camera.look_at((0, 0, 4), (0, 1, 0), fov_y=30.0))


def test_orbits_keep_distance_and_stop_before_the_pole():
    camera = Camera.look_at((3.0, 1.0, 2.0), (1.0, 1.0, 1.0), up=(0.0, 2.0, 0.0))
    turned = camera.orbit(50.0, 30.0)
    offset = np.subtract(turned.position, turned.target)
    assert turned.distance == pytest.approx(camera.distance, rel=EXACT)
    assert math.degrees(math.asin(offset[1] / turned.distance)) == pytest.approx(30.0)
    # From above, +z is at azimuth 0 and +x at 90 degrees.
    azimuths = [math.degrees(math.atan2(*np.subtract(c.position, c.target)[[0, 2]]))
                for c in (camera, turned)]  # fmt: skip
    assert azimuths[1] - azimuths[0] == pytest.approx(50.0)
    top = camera.orbit(0.0, 500.0)
    offset = np.subtract(top.position, top.target)
    assert math.degrees(math.asin(offset[1] / top.distance)) == pytest.approx(89.0)
    assert camera.orbit(0.0) is camera


def test_fit_holds_the_scene_along_any_direction():
    scene = ssdo_gl.load_scene("stairs")
    direction = np.array([-1.0, -2.0, 0.5])
    camera = Camera.fit(scene, direction=direction, fov_y=30.0)
    forward = np.subtract(camera.target, camera.position) / camera.distance
    np.testing.assert_allclose(forward, direction / np.linalg.norm(direction), atol=EXACT)
    assert camera.fov_y == 30.0 and camera.exposure == scene.camera.exposure
    points = np.concatenate(
        [
            placed(scene.meshes[item.mesh].positions, item.world_from_object).reshape(-1, 3)
            for item in scene.objects
        ]
    )
    local = (points - camera.position) @ camera.view_from_world_rotation().T
    slopes = np.abs(local[:, :2]).max(axis=1) / -local[:, 2]
    # The nearest such camera: something reaches the margin.
    assert slopes.max() * MARGIN == pytest.approx(math.tan(math.radians(15.0)))
    assert Camera.fit(scene).fov_y == 40.0


@pytest.mark.parametrize("convention", ["opencv", "opengl"])
def test_a_pose_makes_the_camera_that_has_it(convention):
    camera = Camera.look_at((3.0, 1.0, 2.0), (1.0, -1.0, 1.0), fov_y=35.0)
    rows = camera.view_from_world_rotation()
    flip = np.diag([1.0, -1.0, -1.0] if convention == "opencv" else [1.0, 1.0, 1.0])
    pose = np.column_stack([rows.T @ flip, camera.position])
    np.testing.assert_allclose(camera.pose(convention)[:3], pose, atol=EXACT)
    made = Camera.from_pose(pose, convention, fov_y=35.0)
    np.testing.assert_allclose(made.view_from_world_rotation(), rows, atol=EXACT)
    assert made.position == camera.position and made.fov_y == 35.0
    for wrong in (np.eye(3), np.diag([1.0, 1.0, -1.0, 1.0]), 2.0 * np.eye(4)):
        with pytest.raises(SettingError, match="world_from_camera: expected a rotation"):
            Camera.from_pose(wrong, convention)
    with pytest.raises(SettingError, match="convention = 'colmap': expected one of opengl, opencv"):
        Camera.from_pose(pose, "colmap")


NAMES = ("Front", "from above", "3")


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return save_with_cameras(tmp_path / "a.glb", NAMES, lens="lens")


@pytest.mark.parametrize(
    ("which", "distance"), [(None, 4), ("Front", 4), ("from above", 5), ("3", 6), ("1", 5), (2, 6)]
)
def test_a_camera_is_chosen_by_name_or_number(path: Path, which, distance: int) -> None:
    scene = load_scene(path, camera=which)
    assert scene.camera.position == (0, 0, distance)
    assert not scene.is_framed
    assert [item.name for item in scene.cameras] == list(NAMES)
    assert [item.camera.position[2] for item in scene.cameras] == [4, 5, 6]


def test_fit_frames_all_as_the_flag_does(path: Path) -> None:
    framed = load_scene(path, frames_all=True)
    assert load_scene(path, camera="fit").camera == framed.camera != load_scene(path).camera
    assert load_scene("corner", camera="fit").camera != load_scene("corner").camera


def test_the_motion_is_that_of_the_chosen_camera(path: Path) -> None:
    assert scene_at(load_scene(path), 0.5).camera.position == (0, 0, 4)
    moved = scene_at(load_scene(path, camera="from above"), 0.5).camera
    assert moved.position == pytest.approx((4, 0, 5))


def test_the_others_are_said_unless_one_is_asked_for(path: Path) -> None:
    (note,) = [note for note in load_scene(path).notes if "camera" in note]
    assert note == "seen from the first of the file's cameras: 0 'Front', 1 'from above', 2 '3'"
    assert not any("camera" in note for note in load_scene(path, camera="Front").notes)


@pytest.mark.parametrize(
    ("which", "message"),
    [
        (
            "front",
            "camera 'front': .*has cameras 0 'Front', 1 'from above', 2 '3'; did you mean 'Front'",
        ),
        (9, "camera 9: .*has cameras 0 'Front'"),
        (-1, "camera -1: .*has cameras 0 'Front'"),
        (True, "camera = True: expected the name or number"),
        (1.5, "camera = 1.5: expected the name or number"),
    ],
)
def test_a_camera_that_is_not_there_is_refused(path: Path, which, message: str) -> None:
    with pytest.raises(SettingError, match=message):
        load_scene(path, camera=which)


def test_a_file_without_cameras_says_so(glb: GlbWriter, tmp_path: Path) -> None:
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    file = glb.save(tmp_path / "a.glb")
    with pytest.raises(SettingError, match=r"camera 'Top': .*a\.glb has no cameras"):
        load_scene(file, camera="Top")


@pytest.mark.parametrize(("which", "end"), [("Top", "camera$"), ("fti", "did you mean 'fit'?")])
def test_scene_files_have_one_camera(which: str, end: str) -> None:
    with pytest.raises(SettingError, match=f"camera {which!r}: corner is a scene, .*{end}"):
        load_scene("corner", camera=which)


def test_render_takes_a_name(gl: None, path: Path) -> None:
    size = (16, 9)
    near, far = (
        ssdo_gl.render(path, camera=which, size=size, method="direct")[..., 3].sum()
        for which in ("Front", "3")
    )
    assert near > 1.5 * far > 0
