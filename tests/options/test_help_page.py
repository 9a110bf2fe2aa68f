"""The help page, the list of scenes, and scripts that complete the command."""

from __future__ import annotations

import os
import select
import shlex
import shutil
import subprocess
import sys
import time

import pytest

from ssdo_gl.bench.presets import NAMES
from ssdo_gl.options.flags import build_parser, flag_infos, read_command
from ssdo_gl.options.help_page import EXAMPLES, PRESETS
from ssdo_gl.scene.load import builtin_names, load_scene
from ssdo_gl.settings.fields import SettingError


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
    assert "default 48" in page


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


@pytest.mark.parametrize(
    ("word", "before", "expected"),
    [
        ("corn", "", {"cornell_meso", "corner"}),
        ("reference-", "--method", {"reference-ao", "reference-near", "reference-gi"}),
        ("--sna", "", {"--snapshot"}),
        ("mod", "", {"model.glb"}),
        ("mod", "--snapshot", {"model.glb"}),
        ("mod", "--film", {"model.glb"}),
        ("mod", "--path", {"model.glb"}),
        ("f", "--preset", {"fast", "fine"}),
        ("mod", "--preset", {"model.glb"}),
        ("s", "--light", {"studio", "sky"}),
        ("b", "--aov", {"beauty", "bounce"}),
    ],
)
def test_bash_completes(capsys, tmp_path, word, before, expected):
    pytest.importorskip("shtab")
    bash = shutil.which("bash")
    if bash is None:
        pytest.skip("no bash")
    script = tmp_path / "completion.bash"
    script.write_text(printed(capsys, "--completion", "bash"))
    (tmp_path / "model.glb").touch()
    words = ["ssdo-gl", *([before] if before else []), word]
    ask = f"""source completion.bash
COMP_WORDS=({shlex.join(words)}); COMP_CWORD={len(words) - 1}
_shtab_ssdo_gl; printf '%s\\n' "${{COMPREPLY[@]}}"
"""
    done = subprocess.run([bash, "-c", ask], cwd=tmp_path, capture_output=True, text=True)
    assert set(done.stdout.split()) == expected, done.stderr


def test_presets_that_are_completed_exist():
    assert PRESETS == NAMES


def test_zsh_has_a_script_too(capsys):
    pytest.importorskip("shtab")
    script = printed(capsys, "--completion", "zsh")
    assert script.startswith("#compdef ssdo-gl")
    assert "courtyard" in script


def test_completion_says_what_is_missing(monkeypatch):
    with pytest.raises(SettingError, match="--completion = 'fish': expected one of bash, zsh"):
        read_command(["--completion", "fish"])
    monkeypatch.setitem(sys.modules, "shtab", None)
    with pytest.raises(SettingError, match="pip install 'ssdo_gl\\[completion\\]'"):
        read_command(["--completion", "bash"])


def test_what_prints_and_ends_is_no_setting():
    flags = {o for action in build_parser()._actions for o in action.option_strings}
    declared = {info.flag for _, info in flag_infos().values()}
    assert flags - declared == {"-h", "--help", "--version", "--list-scenes", "--completion"}


def answers(terminal, typed, wanted):
    """Type into a shell, and return what it writes until that holds `wanted`, or five seconds."""
    os.write(terminal, typed.encode())
    shown, end = "", time.monotonic() + 5.0
    while wanted not in shown and time.monotonic() < end:
        if select.select([terminal], [], [], 0.1)[0]:
            shown += os.read(terminal, 65536).decode(errors="replace")
    return shown


def test_zsh_completes(capsys, tmp_path):
    pytest.importorskip("shtab")
    zsh = shutil.which("zsh")
    if zsh is None:
        pytest.skip("no zsh")
    (tmp_path / "_ssdo-gl").write_text(printed(capsys, "--completion", "zsh"))
    # It completes where it edits lines: on a terminal.
    ours, theirs = os.openpty()
    shell = subprocess.Popen([zsh, "-f", "-i"], stdin=theirs, stdout=theirs, stderr=theirs)
    try:
        words = f"PS1=; fpath=({tmp_path} $fpath); autoload -U compinit; compinit -u -D"
        start = f"{words}; echo rea''dy\n"
        assert "ready" in answers(ours, start, "ready")
        for typed, wanted in (
            ("--snap", "--snapshot"),
            ("--method bou", "bounce"),
            ("--camera fit --preset bal", "balanced"),
            ("corner courty", "courtyard"),
        ):
            assert wanted in answers(ours, f"\x15ssdo-gl {typed}\t", wanted)
    finally:
        shell.kill()
        shell.wait()
        os.close(ours)
        os.close(theirs)
