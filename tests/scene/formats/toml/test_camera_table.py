"""Cameras of scene files, and what they see where a file has none."""

from __future__ import annotations

import numpy as np
import pytest
from scene.fixture_types import SceneOf

from ssdo_gl.scene.scene_error import SceneError


def test_camera_title_and_settings(scene_of: SceneOf) -> None:
    result = scene_of(
        """
        title = "T"
        purpose = "P"
        [camera]
        position = [1, 2, 3]
        target = [0, 0.5, 0]
        up = [0, 0, 1]
        fov_y = 55
        exposure = -1.5
        [render]
        radius = 0.25
        method = "ssao"
        samples = 32
        size = [320, 200]
        """
    )
    assert (result.title, result.purpose) == ("T", "P")
    camera = result.camera
    assert (camera.position, camera.target, camera.up) == ((1, 2, 3), (0, 0.5, 0), (0, 0, 1))
    assert (camera.fov_y, camera.exposure) == (55.0, -1.5)
    assert result.render == {
        "radius": 0.25,
        "method": "ssao",
        "samples": 32,
        "size": (320, 200),
    }


def test_cameras_of_parallel_rays(scene_of: SceneOf) -> None:
    where = "[camera]\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\n"
    for word in ("orthographic", "ortho"):
        camera = scene_of(f'{where}projection = "{word}"\nheight = 3').camera
        assert (camera.position, camera.height) == ((0, 0, 5), 3.0)
    # As much as a pinhole would show at the target.
    camera = scene_of(f'{where}projection = "orthographic"\nfov_y = 90').camera
    assert camera.height == pytest.approx(10.0)
    assert scene_of(f'{where}projection = "perspective"').camera.height is None


def test_parallel_rays_frame_the_whole_scene(scene_of: SceneOf) -> None:
    scene = scene_of('[camera]\nprojection = "orthographic"')
    camera = scene.camera
    low, high = scene.bounds()
    corners = np.where(np.indices((2, 2, 2)).reshape(3, 8).T == 1, high, low)
    local = (corners - np.asarray(camera.position)) @ camera.view_from_world_rotation().T
    assert camera.height is not None
    assert np.all(np.abs(local[:, :2]) < 0.5 * camera.height) and np.all(local[:, 2] < 0.0)
    assert camera.height < 1.1 * float(np.ptp(local[:, :2], axis=0).max())


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("height = 3", "belongs to projection"),
        ('projection = "ortho"\nheight = 0', "height = 0: expected a number at least 1e-15"),
        ('projection = "ortho"\nheight = -1', "height = -1"),
        ('projection = "isometric"', "projection = 'isometric': expected one of perspective"),
        ("projection = 3", "projection = 3: expected one of"),
    ],
)
def test_bad_projections_are_refused(scene_of: SceneOf, text: str, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        scene_of(f"[camera]\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\n{text}")


def test_without_a_camera_the_scene_is_framed_with_its_settings(scene_of: SceneOf) -> None:
    camera = scene_of("[camera]\nfov_y = 70\nexposure = 2").camera
    assert (camera.fov_y, camera.exposure) == (70.0, 2.0)
    # The box [0, 1] x [0, 2] x [0, 3] is looked at.
    assert np.all(np.abs(np.subtract(camera.target, (0.5, 1.0, 1.5))) < 0.5)
