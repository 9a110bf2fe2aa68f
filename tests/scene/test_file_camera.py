"""Files with several cameras: which one is seen through, and which there are."""

from __future__ import annotations

from pathlib import Path

import pytest
from glb_writer import GlbWriter, save_with_cameras

import ssdo_gl
from ssdo_gl.scene.animate import scene_at
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings.fields import SettingError

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
