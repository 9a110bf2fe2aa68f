"""Every command and example of README and docs/ runs, or is understood by its program."""

from __future__ import annotations

import importlib.util
import re
import shlex
import tomllib
from typing import NamedTuple

import pytest
from documentation.pages import ROOT, TEXTS, TUTORIAL, blocks, code_spans, first_names, options

from ssdo_gl.bench.presets import load_preset
from ssdo_gl.cli import build_parser, main
from ssdo_gl.options.pass_settings import overrides_from_text
from ssdo_gl.scene.formats.toml import read_description

MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
# Flags of other programs that the pages name.
FOREIGN_FLAGS = {
    "pytest": {"--backend", "--computes"},
    "dask": {"--nthreads"},
    "f3d": {"--output", "--camera-azimuth-angle"},
    **{
        name: set(re.findall(r'"(--[a-z-]+)"', (ROOT / f"benchmarks/{name}.py").read_text("utf-8")))
        for name in ("against_commit", "walk_errors")
    },
}


class Command(NamedTuple):
    """A command line that a page shows."""

    page: str
    line: str


SHELL = [
    Command(block.page, line)
    for block in blocks("sh")
    for line in block.text.splitlines()
    if line.strip()
]
# Lines that show the command's form, or what it prints.
FORMS = [
    Command(block.page, line)
    for block in blocks("text")
    for line in block.text.splitlines()
    if line.startswith("ssdo-gl")
] + [
    Command(page, span)
    for page, text in TEXTS.items()
    for span in code_spans(text)
    if span.startswith("ssdo-gl ")
]


def test_there_is_something_to_test():
    assert len(SHELL) >= 15
    assert len(FORMS) >= 8
    assert len(blocks("python")) >= 4
    assert len(blocks("toml")) >= 2


@pytest.mark.parametrize("command", SHELL, ids=lambda c: c.line[:60])
def test_commands_run(command, tmp_path, monkeypatch):
    words = shlex.split(command.line, comments=True)
    if words[0] != "ssdo-gl":
        check_foreign(words)
        return
    arguments = words[1:]
    modes = {"--snapshot", "--explain", "--batch", "--film"} & set(arguments)
    assert modes, "a window or a bench is no quick test"
    monkeypatch.chdir(tmp_path)
    # As they stand, but small: a later flag wins over an earlier one.
    short = ["--frames-range", "0:2"] if "--film" in modes else []
    assert main([*arguments, *short, "--size", "48x27", "--quiet"]) == 0
    if "--film" in modes:
        out = arguments[arguments.index("--film") + 1]
        assert (tmp_path / (out % 1 if "%" in out else out)).exists()
    if "--batch" in modes:
        assert len(list((tmp_path / arguments[arguments.index("--out") + 1]).iterdir())) > 1
    if "--snapshot" in arguments:
        out = arguments[arguments.index("--snapshot") + 1].replace("{name}", arguments[0])
        assert (tmp_path / out).stat().st_size > 0


def check_foreign(words: list[str]) -> None:
    """Assert that a command of another program names what the project has."""
    program, *arguments = words
    if program == "make":
        targets = [word for word in arguments if "=" not in word]
        assert targets and set(targets) <= make_targets()
        variables = {word.partition("=")[0] for word in arguments if "=" in word}
        assert variables <= set(re.findall(r"^(\w+) \??:?=", MAKEFILE, re.MULTILINE))
    elif program == "pytest":
        flags = {word for word in arguments if word.startswith("-")}
        assert flags <= FOREIGN_FLAGS["pytest"]
        assert all((ROOT / word).exists() for word in arguments if "/" in word)
    elif program == "bash":
        assert (ROOT / arguments[0]).is_file()
    elif words[:2] == ["pip", "install"]:
        extras = re.fullmatch(r"\.(?:\[([\w,]+)\])?", arguments[1])
        assert extras is not None
        assert set(extras[1].split(",") if extras[1] else ()) <= set(optional())
    elif words[:2] == ["python", "-m"]:
        assert importlib.util.find_spec(arguments[1]) is not None
    else:
        pytest.fail(f"no test knows the program {program!r}")


def optional() -> dict[str, list[str]]:
    return dict(PROJECT["optional-dependencies"])


def make_targets() -> set[str]:
    return set(re.findall(r"^([a-z-]+):", MAKEFILE, flags=re.MULTILINE))


@pytest.mark.parametrize("command", FORMS, ids=lambda c: c.line[:60])
def test_forms_of_the_command_are_understood(command):
    # What follows the columns' gap explains the line; brackets mark what may be left out.
    # Pipes are the shell's.
    line = re.split(r"\s{3,}| [<>] ", command.line)[0]
    words = [word.strip("[]") for word in shlex.split(line)]
    build_parser().parse_args(words[1:])


@pytest.mark.parametrize("page", TEXTS)
def test_commands_within_sentences_name_what_exists(page):
    for span in code_spans(TEXTS[page]):
        if re.match(r"(make|pip|python -m|bash) ", span):
            check_foreign([word for word in shlex.split(span) if word != "OUTDIR..."])


def test_every_make_target_is_described_and_exists():
    described = [n.removeprefix("make ") for n in first_names(TEXTS["docs/development.md"])]
    assert sorted(described) == sorted(make_targets())


def test_no_make_target_is_a_file():
    """A file or folder of a target's name would end its work."""
    phony = re.search(r"^\.PHONY: (.*)$", MAKEFILE, re.MULTILINE)
    assert phony and set(phony[1].split()) == make_targets()


@pytest.mark.parametrize("page", TEXTS)
def test_every_flag_that_is_named_exists(page):
    named = set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", TEXTS[page]))
    assert named - options() - set().union(*FOREIGN_FLAGS.values()) == set()


@pytest.mark.parametrize("page", TEXTS)
def test_settings_that_are_named_can_be_set(page):
    for item in re.findall(r"--set ([a-z_]+\.[a-z_]+=[\w.]+)", TEXTS[page]):
        if not item.startswith(f"{TUTORIAL}."):
            assert overrides_from_text([item])


@pytest.mark.parametrize("block", blocks("python"), ids=lambda b: b.page)
def test_python_runs(block, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    small = block.text.replace("(320, 180)", "(32, 18)").replace("(180, 320", "(18, 32")
    exec(compile(small, block.page, "exec"), {})


@pytest.mark.parametrize("block", blocks("toml"), ids=lambda b: b.page)
def test_files_are_read(block, tmp_path):
    if "[settings]" in block.text:
        path = tmp_path / "preset.toml"
        path.write_text(block.text, encoding="utf-8")
        fields = load_preset(str(path))
        overrides = fields.get("overrides", {})
        assert overrides_from_text([f"{name}={value}" for name, value in overrides.items()])
    else:
        assert read_description(block.text, block.page).triangle_count > 0
