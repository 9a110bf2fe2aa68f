"""What holds of all files: no unfinished work, and tests where one looks for them."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path, PurePosixPath

import pytest

ROOT = Path(__file__).parent.parent
FOLDERS = ("ssdo_gl", "shaders", "scenes", "tests", "docs", "benchmarks", ".ci", ".github")
SUFFIXES = {".py", ".glsl", ".frag", ".vert", ".toml", ".md", ".yml", ".yaml", ".sh", ""}
UNFINISHED = re.compile(r"\b(TODO|FIXME|XXX|HACK)\b|NotImplementedError")


def project_files() -> list[Path]:
    """Return the project's own text files, shipped or not."""
    files = [path for path in ROOT.iterdir() if path.is_file()]
    for folder in FOLDERS:
        files += (path for path in (ROOT / folder).rglob("*") if path.is_file())
    # This file has to name what it forbids.
    own = Path(__file__)
    return [p for p in files if p.suffix in SUFFIXES and "__pycache__" not in p.parts and p != own]


def unfinished(text: str) -> list[int]:
    """Return the numbers of the lines that name unfinished work."""
    return [i for i, line in enumerate(text.splitlines(), 1) if UNFINISHED.search(line)]


def test_no_file_names_unfinished_work():
    found = [
        f"{path.relative_to(ROOT)}:{line}"
        for path in project_files()
        for line in unfinished(path.read_text(encoding="utf-8"))
    ]
    assert found == []


def test_unfinished_work_would_be_found():
    assert unfinished("a\n# TODO: later\n") == [2]
    assert unfinished("raise NotImplementedError") == [1]
    assert unfinished("the mastodon and the toadstool") == []


def misplaced_tests(tests: Iterable[str], modules: Iterable[str]) -> list[str]:
    """Return a line for each test file that does not lie where the package has what it tests.

    Both as paths below ``tests`` and ``ssdo_gl``. A folder of tests that the package lacks, as
    ``oracle``, is arranged as it likes.
    """
    modules = set(modules)
    folders = {str(folder) for path in modules for folder in PurePosixPath(path).parents}
    faults = []
    for path in map(PurePosixPath, tests):
        top, folder, name = path.parts[0], path.parent, path.name.removeprefix("test_")
        if top not in folders:
            continue
        if str(folder) not in folders:
            faults.append(f"{path}: the package has no folder {folder}")
        homes = [m for m in modules if m.startswith(f"{top}/") and m.endswith(f"/{name}")]
        if homes and str(folder / name) not in homes:
            faults.append(f"{path} tests {' or '.join(homes)}")
    return faults


def paths_below(folder: Path, pattern: str) -> list[str]:
    """Return the files below `folder` that match, relative to it."""
    return [path.relative_to(folder).as_posix() for path in folder.rglob(pattern)]


def test_tests_mirror_the_package():
    tests = paths_below(ROOT / "tests", "test_*.py")
    assert misplaced_tests(tests, paths_below(ROOT / "ssdo_gl", "*.py")) == []


@pytest.mark.parametrize(
    ("test", "is_misplaced"),
    [
        ("gpu/compute/test_kernel.py", False),
        ("gpu/test_kernel.py", True),
        ("gpu/kernels/test_speed.py", True),
        ("gpu/test_of_several.py", False),
        ("hard_cases/test_kernel.py", False),
        ("test_kernel.py", False),
    ],
)
def test_a_misplaced_test_would_be_found(test, is_misplaced):
    assert len(misplaced_tests([test], ["gpu/compute/kernel.py", "kernel.py"])) == is_misplaced


def test_examples_do_not_depend_on_what_is_loaded():
    """Hypothesis would take constants from every local module, this one's too."""
    providers = pytest.importorskip("hypothesis.internal.conjecture.providers")
    look = getattr(providers, "_get_local_constants", set)
    assert len(look()) == 0
