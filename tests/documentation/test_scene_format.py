"""The page of the scene format names what its reader accepts, and nothing else."""

from __future__ import annotations

import contextlib
import re
from typing import Any

import pytest
from documentation.pages import ROOT, TEXTS, code_spans, first_names, options, section, table

from ssdo_gl.scene.files.table import Table
from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.scene.scene_error import SceneError

FORMAT = "docs/scene-format.md"
LIGHTS = first_names(section(FORMAT, "Lights"))
SHAPES = first_names(section(FORMAT, "Objects"))
# Each is read until its first missing key, which comes after the check of those it has.
TABLES = {
    "top level": "",
    "[camera]": "[camera]",
    "[render]": "[render]",
    "[materials.NAME]": "[materials.red]",
    **{f"environment {k}": f'[environment]\nkind = "{k}"' for k in ("constant", "gradient", "map")},
    **{f"light {kind}": f'[[light]]\nkind = "{kind}"' for kind in LIGHTS},
    **{f"object {shape}": f'[[object]]\nshape = "{shape}"' for shape in SHAPES},
    "details": """[[object]]
        shape = "sphere"
        radius = 1
        bump = { amplitude = 0.1 }
        transform = {}
        repeat = { count = 1, step = [1, 0, 0] }
        animate = {}""",
    "arc": '[[object]]\nshape = "torus"\nradius = 1\nthickness = 0.1\narc = { degrees = 90 }',
}


def read_keys(text: str, monkeypatch: pytest.MonkeyPatch) -> tuple[set[str], set[str]]:
    """Return the keys that may stand in the tables of a scene file, and all choices."""
    keys: set[str] = set()
    choices: set[str] = set()
    allow, take_text = Table.allow, Table.text

    def recording_allow(self: Table, *known: str) -> None:
        keys.update(known)
        allow(self, *known)

    def recording_text(self: Table, key: str, *args: Any, **kwargs: Any) -> str:
        choices.update(kwargs.get("choices", args[1] if len(args) > 1 else ()))
        return take_text(self, key, *args, **kwargs)

    with monkeypatch.context() as patch, contextlib.suppress(SceneError):
        patch.setattr(Table, "allow", recording_allow)
        patch.setattr(Table, "text", recording_text)
        read_description(text, FORMAT)
    return keys, choices


@pytest.mark.parametrize("name", TABLES)
def test_the_scene_format_names_every_key_and_choice(name, monkeypatch):
    keys, choices = read_keys(TABLES[name], monkeypatch)
    assert keys
    words = set(re.findall(r"\w+", " ".join(code_spans(TEXTS[FORMAT]))))
    if name == "[render]":
        # They are those of the flags, which have a page.
        keys -= {option.removeprefix("--").replace("-", "_") for option in options()}
    assert keys - words == set()
    assert choices - words == set()


@pytest.mark.parametrize("kind", [*LIGHTS, *SHAPES])
def test_the_scene_format_names_no_other_keys(kind, monkeypatch):
    (row,) = (row for row in table(TEXTS[FORMAT]) if kind in code_spans(row[0]) and len(row) == 2)
    listed = {span.split()[0] for span in code_spans(row[1])}
    family = "light" if kind in LIGHTS else "object"
    known, _ = read_keys(TABLES[f"{family} {kind}"], monkeypatch)
    assert listed and listed <= known


def test_every_built_in_scene_is_described():
    names = first_names(section(FORMAT, "Built-in scenes"))
    assert sorted(names) == sorted(path.stem for path in (ROOT / "scenes").glob("*.toml"))
