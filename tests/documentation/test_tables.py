"""Tables of README and docs/ say what the program says."""

from __future__ import annotations

import dataclasses
import json
import re

from documentation.pages import TEXTS, code_spans, first_names, section, settings_table, table

import ssdo_gl
from ssdo_gl import cli, process
from ssdo_gl.bench.presets import read_ladder
from ssdo_gl.effects import registry
from ssdo_gl.settings import AOVS
from ssdo_gl.settings.estimators import ESTIMATORS
from ssdo_gl.settings.methods import METHODS
from ssdo_gl.window.input.bindings import help_groups


def test_the_table_of_flags_is_that_of_the_program():
    assert settings_table() in section("docs/command.md", "Flags")


def test_what_stats_hold_is_what_the_page_says(tmp_path):
    stats = tmp_path / "stats.json"
    words = ["corner", "--explain", "--method", "direct", "--size", "16x9", "--quiet"]
    assert cli.main([*words, "--stats", str(stats)]) == 0
    text = section("docs/command.md", "Outputs")
    text = text[text.index("`--stats FILE.json` holds") :].split("`timer` is")[0]
    named = code_spans(re.sub(r"\([^)]*\)", "", text))[1:]
    assert named == list(json.loads(stats.read_text()))


def test_the_table_of_public_names_is_that_of_the_package():
    rows = table(section("docs/python.md", "From Python"))
    listed = {name for row in rows for name in code_spans(row[0])}
    assert listed == set(ssdo_gl.__all__) - {"__version__"}


def test_methods_are_those_of_the_program():
    for page, heading in (
        ("README.md", "What it draws"),
        ("docs/architecture.md", "Quantities"),
    ):
        names = first_names(section(page, heading))
        assert [name for name in names if name in METHODS][-len(METHODS) :] == list(METHODS)


def test_the_table_of_estimators_is_that_of_the_program():
    rows = table(section("docs/estimators.md", "The field"))
    gives = {name: "visibility, light" if e.gives_light else "visibility"
             for name, e in ESTIMATORS.items()}  # fmt: skip
    assert {code_spans(row[0])[0]: row[-1] for row in rows} == gives


def test_the_table_of_images_is_that_of_the_program():
    names = first_names(section("docs/command.md", "Outputs"))
    assert tuple(names) == AOVS


def test_the_table_of_exit_codes_is_that_of_the_program():
    rows = table(section("docs/command.md", "Exit codes"))
    known = {**vars(cli), **vars(process)}
    codes = {value for name, value in known.items() if name.startswith("EXIT_")}
    assert {int(row[0]) for row in rows} == codes


def test_the_table_of_pass_settings_is_that_of_the_program():
    listed = {
        f"{name}.{code_spans(row[0])[0]}": row[2]
        for row in table(section("docs/command.md", "Settings of passes"))
        for name in code_spans(row[1])
    }
    assert listed == {
        f"{name}.{field.name}": shown(field.default)
        for name, settings in registry.pass_settings().items()
        for field in dataclasses.fields(settings)
    }


def shown(value: object) -> str:
    """Return a default as the tables print it."""
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return f"{value:g}" if is_number else str(value).lower()


def test_the_table_of_effects_is_that_of_the_registry():
    rows = table(section("docs/effects.md", "The effects"))
    listed = {code_spans(row[0])[0]: row[2] for row in rows}
    assert list(listed) == [effect.name for effect in registry.effects()]
    for effect in registry.effects():
        said = listed[effect.name]
        named = set(code_spans(said)) & set(METHODS)
        if said.startswith("with "):
            assert not effect.methods
        else:
            assert effect.methods == (set(METHODS) - named if "but" in said else named)


def key_labels(cell: str) -> list[str]:
    return cell.replace("`", "").split(", ")


def test_the_tables_of_keys_are_those_of_the_window():
    bound = {
        label for rows in help_groups().values() for cell, _ in rows for label in key_labels(cell)
    }
    listed = [k for row in table(section("docs/window.md", "Keys")) for k in key_labels(row[0])]
    assert len(set(listed)) == len(listed)
    assert set(listed) == bound
    rows = table(section("README.md", "The window"))
    assert len(rows) == 10
    assert {label for row in rows for label in key_labels(row[0])} <= bound


def test_the_tables_of_presets_are_those_of_the_ladder():
    ladder = read_ladder()
    wanted = []
    names = {rung: name for name, rung in ladder.presets.items()}
    for index, rung in enumerate(ladder.rungs):
        directions = max(1, rung.samples // rung.steps)
        wanted.append(
            [
                f"`{names[index]}`" if index in names else "",
                f"{rung.samples} in {directions}",
                "half" if rung.resolution_scale == 0.5 else "full",
                f"{rung.relative_time:.2f}",
                f"{100 * rung.error:.1f} %",
            ]
        )
    baseline, *rungs = table(section("docs/accuracy.md", "Presets"))
    assert rungs == wanted
    short_baseline, *presets = table(section("README.md", "What accuracy costs"))
    assert presets == [row for row in wanted if row[0]]
    assert short_baseline[1:] == baseline[1:]


def test_the_readme_has_the_time_of_a_frame_of_gi_beside_peers():
    rows = table(section("docs/peers.md", "What was found"))
    milliseconds = next(float(row[3]) for row in rows if row[0].startswith("`gi`"))
    (seconds,) = re.findall(r"`gi` from a new point of view takes (\.\d+) s", TEXTS["README.md"])
    assert float(seconds) == round(milliseconds / 1e3, 2)
