"""The scripts behind `make setup`, on made-up systems: who may install, and what is asked."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
BASH = shutil.which("bash") or ""
# Python 3.9's answers to what .ci/setup asks of an interpreter.
OLD_PYTHON = 'case "$1" in --version) echo Python 3.9.2;; -c) exit 1;; esac'

pytestmark = pytest.mark.skipif(not BASH, reason="the scripts need bash")


def run(
    script: str, tools: dict[str, str], folder: Path, *arguments: str, **environment: str
) -> subprocess.CompletedProcess[str]:
    """Run a script of .ci on a system that has nothing but `tools` and a few basics."""
    folder.mkdir(exist_ok=True)
    for name, body in tools.items():
        (folder / name).write_text(f"#!{BASH}\n{body}\n")
        (folder / name).chmod(0o755)
    for name in ("bash", "dirname", "env", "grep"):
        os.symlink(shutil.which(name) or "", folder / name)
    return subprocess.run(
        [BASH, str(ROOT / ".ci" / script), *arguments],
        env={"PATH": str(folder), **environment},
        capture_output=True,
        text=True,
        check=False,
    )


HAS_ONLY_LIBGL1 = 'for last; do :; done; if [ "$last" = libgl1 ]; then echo installed; fi'
LOG_CALLS = 'echo "$0 $*" >&2'


def test_nothing_is_done_where_all_is_installed(tmp_path):
    answer = run("packages", {"dpkg-query": "echo installed"}, tmp_path / "bin", "libgl1")
    assert (answer.returncode, answer.stdout, answer.stderr) == (0, "", "")


def test_root_installs_what_is_missing_after_an_update(tmp_path):
    tools = {"dpkg-query": HAS_ONLY_LIBGL1, "id": "echo 0", "apt-get": LOG_CALLS}
    answer = run("packages", tools, tmp_path / "bin", "libegl1", "libgl1")
    assert answer.returncode == 0
    update, install = answer.stderr.splitlines()
    assert "apt-get update" in update
    assert "apt-get install" in install and install.split()[-1] == "libegl1"


def test_sudo_is_used_where_it_asks_for_no_password(tmp_path):
    tools = {
        "dpkg-query": HAS_ONLY_LIBGL1,
        "id": "echo 1000",
        "sudo": 'echo "sudo $*" >&2',
        "apt-get": "exit 9",
    }
    answer = run("packages", tools, tmp_path / "bin", "libegl1")
    assert answer.returncode == 0, "apt-get itself was called"
    assert "sudo -n apt-get update" in answer.stderr


@pytest.mark.parametrize(
    "tools",
    [
        {"id": "echo 1000", "apt-get": "exit 9"},
        {"id": "echo 1000", "apt-get": "exit 9", "sudo": "exit 1"},
        {"id": "echo 0", "apt-get": "exit 100"},
        {"id": "echo 0"},
    ],
    ids=["no sudo", "sudo asks for a password", "apt-get fails", "no apt-get"],
)
def test_who_may_not_install_is_told_what_to_ask_for(tools, tmp_path):
    tools = {"dpkg-query": HAS_ONLY_LIBGL1, **tools}
    answer = run("packages", tools, tmp_path / "bin", "libegl1", "libgl1", "libosmesa6")
    assert answer.returncode == 1
    assert "libegl1 libosmesa6" in answer.stderr.splitlines()[-1]


@pytest.mark.parametrize(
    ("tools", "message"),
    [
        ({}, "there is no python9; install Python 3.11 or newer"),
        ({"python9": OLD_PYTHON}, "Python 3.9.2 is too old"),
        (
            {"python9": 'case "$2" in *ensurepip*) exit 1;; esac', "id": "echo 1000",
             "apt-get": "exit 9", "dpkg-query": "exit 1"},
            "apt-get install python3-venv",
        ),
    ],
    ids=["missing", "too old", "without venv"],
)  # fmt: skip
def test_unusable_python_is_one_clear_line(tools, message, tmp_path):
    answer = run("setup", tools, tmp_path / "bin", PYTHON="python9", VENV=str(tmp_path / "venv"))
    assert answer.returncode == 1
    assert message in answer.stderr
    assert not (tmp_path / "venv").exists()
