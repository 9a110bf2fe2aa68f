"""What `pip install` gives: every shader and scene, found in each way of installing."""

from __future__ import annotations

import email
import email.policy
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest
from python_process import run_python

ROOT = Path(__file__).parent.parent
KINDS = ("shaders", "scenes")
# Prints where the package lies, then reads a shader, its include and a scene.
PROBE = """
import ssdo_gl
from ssdo_gl import resources
print(ssdo_gl.__file__)
shaders = resources.folder("shaders")
assert "#version 330 core" in shaders.joinpath("passes/fullscreen.vert").read_text(encoding="utf-8")
assert "PI" in shaders.joinpath("lib", "constants.glsl").read_text(encoding="utf-8")
scenes = [item for item in resources.folder("scenes").iterdir() if item.name.endswith(".toml")]
assert scenes and all(scene.read_text(encoding="utf-8") for scene in scenes)
"""


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """A folder with sdist and wheel, the latter built from the former, as pip would, offline."""
    out = tmp_path_factory.mktemp("dist")
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(out), str(ROOT)]
    answer = subprocess.run(command, capture_output=True, text=True, check=False)
    assert answer.returncode == 0, answer.stdout + answer.stderr
    return out


@pytest.fixture(scope="module")
def wheel(built):
    (path,) = built.glob("*.whl")
    return path


@pytest.fixture(scope="module")
def sdist(built):
    """The names of all files of the sdist, relative to its root."""
    (path,) = built.glob("*.tar.gz")
    with tarfile.open(path) as archive:
        return {name.partition("/")[2] for name in archive.getnames()}


def shipped(kind: str) -> set[str]:
    """Return the files of a kind in the checkout, relative to its root."""
    return {
        path.relative_to(ROOT).as_posix()
        for path in (ROOT / kind).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }


def probe(path: Path, cwd: Path) -> str:
    """Run PROBE with `path` first on the module search path; return where it was found."""
    answer = run_python("-c", PROBE, path=path, cwd=cwd)
    assert answer.returncode == 0, answer.stderr
    return answer.stdout.strip()


@pytest.mark.parametrize("kind", KINDS)
def test_wheel_holds_the_files_of_the_checkout(wheel, kind):
    prefix = f"ssdo_gl/{kind}/"
    names = {n for n in zipfile.ZipFile(wheel).namelist() if n.startswith(prefix)}
    assert {n.removeprefix("ssdo_gl/") for n in names} == shipped(kind) != set()


def test_wheel_holds_every_module_and_nothing_else(wheel):
    names = {n for n in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in n}
    code = {n for n in names if not n.startswith(tuple(f"ssdo_gl/{kind}/" for kind in KINDS))}
    modules = {
        path.relative_to(ROOT).as_posix()
        for path in (ROOT / "ssdo_gl").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert code == modules


@pytest.mark.parametrize("kind", ["docs", "benchmarks", "tests", ".ci", ".github/pictures"])
def test_sdist_holds_what_documents_and_tests_it(sdist, kind):
    assert shipped(kind) - sdist == set() != shipped(kind)


def test_sdist_holds_the_files_beside_the_folders(sdist):
    assert {"README.md", "CHANGELOG.md", "LICENSE", "Makefile", "pyproject.toml"} <= sdist


def test_unpacked_wheel_finds_its_own_files(wheel, tmp_path):
    site = tmp_path / "site"
    zipfile.ZipFile(wheel).extractall(site)
    assert Path(probe(site, tmp_path)) == site / "ssdo_gl" / "__init__.py"


def test_zipped_wheel_finds_its_own_files(wheel, tmp_path):
    assert probe(wheel, tmp_path).startswith(str(wheel))


def test_plain_checkout_finds_its_own_files(tmp_path):
    assert Path(probe(ROOT, tmp_path)) == ROOT / "ssdo_gl" / "__init__.py"


def test_metadata_names_command_licence_and_version(wheel):
    archive = zipfile.ZipFile(wheel)
    (info,) = {n.split("/")[0] for n in archive.namelist() if ".dist-info/" in n}
    scripts = archive.read(f"{info}/entry_points.txt").decode()
    assert "ssdo-gl = ssdo_gl.__main__:main" in scripts
    assert any(n.startswith(f"{info}/licenses/") for n in archive.namelist())
    import ssdo_gl

    assert info == f"ssdo_gl-{ssdo_gl.__version__}.dist-info"


def test_metadata_holds_the_readme(wheel):
    archive = zipfile.ZipFile(wheel)
    (name,) = (n for n in archive.namelist() if n.endswith(".dist-info/METADATA"))
    metadata = email.message_from_bytes(archive.read(name), policy=email.policy.default)
    assert metadata["Description-Content-Type"] == "text/markdown"
    assert metadata.get_payload() == (ROOT / "README.md").read_text(encoding="utf-8")


def test_extra_all_is_the_union_of_the_others():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = dict(project["optional-dependencies"])
    (everything,) = extras.pop("all")
    assert everything == f"ssdo_gl[{','.join(extras)}]"
