"""The README's commands and code run as they stand there."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from ssdo_gl.cli import build_parser, main

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
MAKEFILE = (Path(__file__).parents[1] / "Makefile").read_text(encoding="utf-8")


def blocks(language):
    """Return the contents of the fenced blocks of one language."""
    return re.findall(rf"^```{language}\n(.*?)^```", README, flags=re.DOTALL | re.MULTILINE)


COMMANDS = [line for block in blocks("sh") for line in block.splitlines() if line.strip()]


def test_there_are_commands_and_code_to_test():
    assert len(COMMANDS) >= 5
    assert blocks("python")


@pytest.mark.parametrize("line", COMMANDS)
def test_commands_run(line, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    program, *arguments = shlex.split(line)
    assert program == "ssdo-gl"
    # As they stand, but small: a later flag wins over an earlier one.
    assert main([*arguments, "--size", "48x27", "--quiet"]) == 0
    if "--snapshot" in arguments:
        assert (tmp_path / arguments[arguments.index("--snapshot") + 1]).stat().st_size > 0


@pytest.mark.parametrize("code", blocks("python"))
def test_python_runs(code, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(code.replace("(320, 180)", "(32, 18)"), "README.md", "exec"), {})


def test_every_flag_that_is_named_exists():
    known = {option for action in build_parser()._actions for option in action.option_strings}
    named = set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", README))
    foreign = {"--backend"} & known | {"--ff-only"}
    assert named - known - foreign == set()


def test_every_flag_of_the_command_is_described():
    known = {option for action in build_parser()._actions for option in action.option_strings}
    missing = {flag for flag in known if flag.startswith("--") and flag not in README}
    assert missing <= {"--help", "--version", "--quiet"}


def test_every_make_target_that_is_named_exists():
    targets = set(re.findall(r"^([a-z-]+):", MAKEFILE, flags=re.MULTILINE))
    assert {"snapshot", "test"} <= targets
    assert set(re.findall(r"\bmake ([a-z-]+)", README)) - targets <= {"sure"}


def test_pictures_exist():
    for path in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", README):
        assert (Path(__file__).parents[1] / path).is_file(), path
