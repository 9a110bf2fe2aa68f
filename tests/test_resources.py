"""Shipped files are found in a checkout and nowhere by accident."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
from python_process import run_python

from ssdo_gl import resources

FIND = "from ssdo_gl import resources; print(resources.folder('shaders').joinpath('x').read_text())"


def test_shaders_and_scenes_are_found():
    assert resources.folder("shaders").joinpath("lib", "constants.glsl").is_file()
    assert any(item.name.endswith(".toml") for item in resources.folder("scenes").iterdir())


@pytest.fixture
def installation(tmp_path):
    """A folder on the path with nothing but the package's resource finder in it."""
    (tmp_path / "ssdo_gl").mkdir()
    (tmp_path / "ssdo_gl" / "__init__.py").touch()
    shutil.copy(resources.__file__, tmp_path / "ssdo_gl")
    return tmp_path


def find_in(folder: Path) -> subprocess.CompletedProcess[str]:
    return run_python("-c", FIND, path=folder, cwd=folder)


def put(folder: Path, text: str) -> None:
    folder.mkdir(parents=True)
    (folder / "x").write_text(text)


def test_folder_inside_the_package_wins(installation):
    put(installation / "ssdo_gl" / "shaders", "inside")
    put(installation / "shaders", "beside")
    (installation / "pyproject.toml").touch()
    assert find_in(installation).stdout.strip() == "inside"


def test_folder_beside_the_package_is_taken_in_a_checkout(installation):
    put(installation / "shaders", "beside")
    (installation / "pyproject.toml").touch()
    assert find_in(installation).stdout.strip() == "beside"


def test_stray_folder_beside_an_installed_package_is_not_taken(installation):
    put(installation / "shaders", "of another distribution")
    answer = find_in(installation)
    assert answer.stdout == ""
    assert "FileNotFoundError" in answer.stderr and "'shaders' is missing" in answer.stderr
