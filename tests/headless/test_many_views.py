"""Many cameras in one call, and the matrices that say where their pixels look."""

from __future__ import annotations

import doctest
import json

import numpy as np
import pytest

import ssdo_gl
import ssdo_gl.headless.many_views
from ssdo_gl import cli
from ssdo_gl.effects.registry import image_names
from ssdo_gl.scene.scene_error import SceneError
from ssdo_gl.settings.fields import SettingError

SIZE = (40, 24)
CAMERAS = (
    ssdo_gl.Camera.look_at((2.0, 1.5, 3.0), (0.1, -0.2, 0.0), fov_y=50.0),
    ssdo_gl.Camera.look_at((-1.5, 2.5, 2.0), up=(0.2, 1.0, 0.1), fov_y=25.0),
    ssdo_gl.Camera.look_at((2.0, 1.5, 3.0), height=2.0),
)
# Positions and depths are float32 images of numbers near 4.
PIXELS, LENGTHS = 1e-4, 2e-6


@pytest.fixture(scope="module")
def views():
    aov = ("position_ws", "depth", "normal_ws", "albedo")
    return list(ssdo_gl.render_views("corner", CAMERAS, aov=aov, size=SIZE))


def seen(view):
    """Return pixels (N, 2) as column and row, world points (N, 3) and depths (N,)."""
    depth = view.images["depth"][..., 0]
    rows, columns = np.nonzero(depth > 0.0)
    points = view.images["position_ws"][rows, columns].astype(np.float64)
    return np.column_stack([columns, rows]), points, depth[rows, columns]


def moved(matrix, points):
    return points @ matrix[:3, :3].T + matrix[:3, 3]


@pytest.mark.parametrize("index", range(len(CAMERAS)))
def test_opencv_matrices_lead_to_the_pixel(views, index):
    view, camera = views[index], CAMERAS[index]
    assert view.camera == camera
    pixels, points, depth = seen(view)
    assert len(pixels) > 100
    local = moved(camera.extrinsics("opencv"), points)
    np.testing.assert_allclose(local[:, 2], depth, atol=LENGTHS)
    divided = local / local[:, 2:] if camera.height is None else local * (1, 1, 0) + (0, 0, 1)
    projected = divided @ camera.intrinsics(SIZE).T
    np.testing.assert_allclose(projected[:, :2], pixels, atol=PIXELS)


@pytest.mark.parametrize("index", range(len(CAMERAS)))
def test_opengl_matrices_lead_to_the_pixel(views, index):
    view, camera = views[index], CAMERAS[index]
    pixels, points, depth = seen(view)
    local = moved(camera.extrinsics("opengl"), points)
    np.testing.assert_allclose(-local[:, 2], depth, atol=LENGTHS)
    clip = np.column_stack([local, np.ones(len(local))]) @ camera.projection(SIZE, 0.5, 20.0).T
    ndc = clip[:, :3] / clip[:, 3:]
    # Row 0 is at the top, and y of clip space grows upwards.
    window = (ndc[:, :2] * (1.0, -1.0) + 1.0) / 2.0 * SIZE - 0.5
    np.testing.assert_allclose(window, pixels, atol=PIXELS)
    assert np.all(np.abs(ndc[:, 2]) < 1.0)


def test_poses_are_the_inverse_and_make_the_camera_again(views):
    for camera in CAMERAS:
        for convention in ("opencv", "opengl"):
            product = camera.pose(convention) @ camera.extrinsics(convention)
            np.testing.assert_allclose(product, np.eye(4), atol=1e-12)
    camera = CAMERAS[1]
    made = ssdo_gl.Camera.from_pose(camera.pose(), fov_y=camera.fov_y)
    (again,) = ssdo_gl.render_views("corner", [made], aov="position_ws", size=SIZE)
    before = views[1].images["position_ws"]
    np.testing.assert_allclose(again.images["position_ws"], before, atol=1e-4)


def test_each_view_is_the_picture_of_its_camera_alone(views):
    with ssdo_gl.Renderer(
        ssdo_gl.load_scene("corner"), ssdo_gl.Settings(size=SIZE)
    ) as renderer:  # fmt: skip
        for view, camera in zip(views, CAMERAS, strict=True):
            alone = renderer.render(view.images, camera=camera).images
            for name, image in view.images.items():
                np.testing.assert_array_equal(image, alone[name])


def test_all_images_and_files_have_the_matrices(tmp_path):
    views = ssdo_gl.render_views("corner", CAMERAS[:1], aov="all", size=(8, 6), samples=8)
    for view in views:
        assert set(view.images) == set(image_names())
        view.save(tmp_path / "view.npz")
    with np.load(tmp_path / "view.npz") as file:
        camera = json.loads(str(file["meta"]))["camera"]
    np.testing.assert_array_equal(camera["intrinsics"], CAMERAS[0].intrinsics((8, 6)))
    np.testing.assert_array_equal(camera["extrinsics_opengl"], CAMERAS[0].extrinsics("opengl"))
    assert camera["position"] == [2.0, 1.5, 3.0] and camera["fov_y"] == 50.0


@pytest.mark.parametrize(
    ("flags", "name"),
    [
        (["--snapshot", "view.npz"], "view.npz"),
        (
            ["--film", "view_%02d.npz", "--frames-range", "0:1/4", "--turntable", "90"],
            "view_00.npz",
        ),
    ],
)
def test_files_of_the_command_have_them_too(tmp_path, monkeypatch, flags, name):
    monkeypatch.chdir(tmp_path)
    small = ["--size", "8x6", "--method", "direct", "--aov", "depth", "--quiet"]
    assert cli.main(["corner", *flags, *small, "--camera", "2,1.5,3 0,0,0 50"]) == 0
    with np.load(name) as file:
        camera = json.loads(str(file["meta"]))["camera"]
    np.testing.assert_allclose(camera["intrinsics"], CAMERAS[0].intrinsics((8, 6)))
    wanted = ssdo_gl.Camera.look_at((2, 1.5, 3), fov_y=50).extrinsics("opencv")
    np.testing.assert_allclose(camera["extrinsics_opencv"], wanted, atol=1e-12)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"cameras": [CAMERAS[0], (0, 0, 4)]}, SettingError, r"cameras\[1\]: expected a Camera"),
        ({"cameras": CAMERAS[0]}, SettingError, "cameras = Camera.*: expected several Cameras"),
        ({"aov": ["depht"]}, SettingError, "image 'depht': choose of"),
        ({"source": "nowhere"}, SceneError, "no built-in scene is called 'nowhere'"),
        ({"samples": 0}, SettingError, "samples = 0"),
    ],
)
def test_faults_are_told_before_anything_is_drawn(arguments, error, message):
    with pytest.raises(error, match=message):
        ssdo_gl.render_views(**{"source": "corner", "cameras": CAMERAS, **arguments})


def test_the_documented_example_runs():
    results = doctest.testmod(ssdo_gl.headless.many_views)
    assert results.attempted >= 4 and results.failed == 0
