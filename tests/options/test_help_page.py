"""The help page, and the list of scenes."""

from __future__ import annotations

import shlex

import pytest

from ssdo_gl.options.flags import build_parser, flag_infos, read_command
from ssdo_gl.options.help_page import EXAMPLES
from ssdo_gl.scene.load import builtin_names, load_scene


def printed(capsys, *arguments):
    with pytest.raises(SystemExit) as stop:
        read_command(arguments)
    assert stop.value.code in (0, None)
    return capsys.readouterr().out


def test_the_help_page_names_flags_scenes_and_examples(capsys):
    page = printed(capsys, "--help")
    for wanted in [*builtin_names(), *(info.flag for _, info in flag_infos().values())]:
        assert wanted in page
    assert EXAMPLES in page
    assert "default 64" in page


def test_the_help_page_fits_a_terminal_of_80_columns(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    assert max(map(len, printed(capsys, "--help").splitlines())) <= 80


@pytest.mark.parametrize("line", [line for line in EXAMPLES.splitlines() if "ssdo-gl" in line])
def test_examples_are_valid(line):
    words = shlex.split(line.strip().split("   ")[0])[1:]
    assert read_command(words)


def test_scenes_are_listed_with_their_purpose(capsys):
    listed = printed(capsys, "--list-scenes")
    for name in builtin_names():
        scene = load_scene(name)
        assert f"{name}: {scene.title}\n" in listed
        assert " ".join(scene.purpose.split()) in " ".join(listed.split())


def test_what_prints_and_ends_is_no_setting():
    flags = {o for action in build_parser()._actions for o in action.option_strings}
    declared = {info.flag for _, info in flag_infos().values()}
    assert flags - declared == {"-h", "--help", "--version", "--list-scenes"}
