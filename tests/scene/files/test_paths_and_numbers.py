"""Paths and numbers of scene and material files pass one gate each."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

import ssdo_gl
from ssdo_gl.scene.geometry.topology import are_mirrored
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene_error import SceneError

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


def refusal(path: Path | str) -> str:
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 500
    return str(caught.value)


def test_names_too_long_for_the_system(tmp_path: Path) -> None:
    for suffix in (".obj", ".gltf", ".toml", ".ply"):
        assert "File name too long" in refusal(tmp_path / ("n" * 300 + suffix))
    assert "no built-in scene" in refusal("n" * 5000)
    scene = tmp_path / "a.toml"
    scene.write_text(f"[[object]]\nshape = 'mesh'\npath = '{'n' * 300}.obj'\n")
    assert "File name too long" in refusal(scene)


@pytest.mark.parametrize("suffix", [".obj", ".gltf", ".glb", ".toml", ".ply", ".stl", ".off"])
def test_a_folder_of_a_models_name(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"x{suffix}"
    path.mkdir()
    assert "is a folder" in refusal(path)


@pytest.mark.parametrize("suffix", [".obj", ".gltf", ".toml"])
def test_a_pipe_of_a_models_name(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"x{suffix}"
    os.mkfifo(path)
    assert "is a pipe or device" in refusal(path)


@pytest.mark.parametrize("suffix", [".obj", ".gltf", ".glb", ".toml", ".ply", ".stl", ".off"])
def test_a_pointer_of_git_lfs_is_called_one(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"x{suffix}"
    path.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n")
    assert "git lfs pull" in refusal(path)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_files_that_may_not_be_read(tmp_path: Path) -> None:
    folder = tmp_path / "closed"
    folder.mkdir()
    (folder / "a.obj").write_text(TRIANGLE)
    folder.chmod(0)
    try:
        assert "Permission denied" in refusal(folder / "a.obj")
    finally:
        folder.chmod(0o700)


def test_a_material_library_that_cannot_be_read_is_a_note(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a.mtl").write_text("newmtl m\nKd 1 0 0\n")
    path = tmp_path / "a.obj"
    path.write_text(f"mtllib a.mtl\n{TRIANGLE}f 1 2 3\n")
    read = Path.read_bytes

    def refuse(self: Path) -> bytes:
        if self.suffix == ".mtl":
            raise PermissionError(13, "Permission denied")
        return read(self)

    monkeypatch.setattr(Path, "read_bytes", refuse)
    notes = load_scene(path).notes
    assert any("a.mtl" in note and "Permission denied" in note for note in notes)


@pytest.mark.parametrize("text", ["1e39 1 1", "nan 0 0", "inf 0 0", "-1 0 0", "1e300 0 0"])
def test_emission_of_mtl_files_is_finite_or_refused(text: str, tmp_path: Path) -> None:
    (tmp_path / "a.mtl").write_text(f"newmtl m\nKe {text}\n")
    path = tmp_path / "a.obj"
    path.write_text(f"mtllib a.mtl\n{TRIANGLE}usemtl m\nf 1 2 3\n")
    assert "Ke" in refusal(path)


def test_a_damaged_texture_of_an_mtl_file_is_a_note(tmp_path: Path) -> None:
    (tmp_path / "leaf.png").write_bytes(b"no picture")
    (tmp_path / "a.mtl").write_text("newmtl m\nmap_Kd leaf.png\n")
    path = tmp_path / "a.obj"
    path.write_text(f"mtllib a.mtl\n{TRIANGLE}usemtl m\nf 1 2 3\n")
    scene = load_scene(path)
    assert any("'leaf.png' is not a readable image" in note for note in scene.notes)


SPHERE = "[[object]]\nshape = 'sphere'\nradius = 1\n"


@pytest.mark.parametrize(
    ("text", "named"),
    [
        (f"[camera]\nfov_y = {'9' * 5000}\n{SPHERE}", "thousands of digits"),
        (f"[camera]\nfov_y = 0x{'f' * 5000}\n{SPHERE}", "a whole number of thousands of digits"),
        (f"title = {'[' * 3000}{']' * 3000}\n", "nested too deeply"),
        (f"title = {'[' * 200}{']' * 200}\n", "title = [[["),
        (f"camera{'.a' * 3000} = 1\n{SPHERE}", "unknown key 'a'"),
        (f"title{'.a' * 3000} = 1\n{SPHERE}", "title = a value nested thousands deep"),
    ],
)
def test_digits_and_nesting_by_the_thousand(text: str, named: str, tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_text(text)
    assert named in refusal(path)


@pytest.mark.parametrize("size", ["1e-320", "1e-300", "1e-30"])
def test_a_body_too_small_for_single_precision_is_drawn_without_a_word(
    size: str, tmp_path: Path
) -> None:
    path = tmp_path / "a.toml"
    path.write_text(f"{SPHERE}{SPHERE.replace('radius = 1', f'radius = {size}')}")
    with_speck = ssdo_gl.render(path, size=(32, 18), shadows="traced")
    path.write_text(SPHERE)
    assert np.array_equal(with_speck, ssdo_gl.render(path, size=(32, 18), shadows="traced"))


def test_are_mirrored_whatever_the_scale() -> None:
    linear = np.array([np.diag([x, y, 1.0]) for x in (1.0, -1e-320) for y in (1e200, -1e-320)])
    matrices = np.zeros((4, 4, 4))
    matrices[:, :3, :3] = linear
    assert are_mirrored(matrices).tolist() == [False, True, True, False]
    assert are_mirrored(np.zeros((1, 3, 4))).tolist() == [False]
