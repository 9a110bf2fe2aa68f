"""Settings carry their range, and a wrong value is refused with what would be right."""

from __future__ import annotations

import math
from dataclasses import dataclass

import pytest

from ssdo_gl.settings.fields import SettingError, check, describe, from_file, parse, setting


@dataclass(frozen=True)
class Example:
    radius: float | None = setting(
        0.5, "reach", unit="scene units", low=0.0, high=10.0, also=(math.inf,)
    )
    gain: float = setting(1.0, "how bright")
    size: tuple[int, int] = setting((4, 3), "of the picture", unit="px", low=1, high=16)
    count: int = setting(8, "reads", low=1, high=64)
    mode: str = setting("march", "how", choices=("march", "rgs09"))
    soft: bool = setting(True, "soft shadows")


def test_every_field_describes_itself():
    info = describe(Example)["count"]
    assert (info.default, info.low, info.high, info.doc) == (8, 1, 64, "reads")


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("radius", "0.25", 0.25),
        ("radius", "inf", float("inf")),
        ("gain", "-1e38", -1e38),
        ("size", "16x9", (16, 9)),
        ("count", "64", 64),
        ("mode", "rgs09", "rgs09"),
        ("soft", "false", False),
    ],
)
def test_texts_become_values(name, text, value):
    assert parse(Example, name, text) == value


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("radius", "-1", "radius = -1.0: expected a number from 0 to 10 scene units, or inf"),
        ("radius", "nan", "radius = nan"),
        ("radius", "wide", "radius = 'wide': expected a number"),
        ("gain", "1e39", "gain = 1e.39: expected a number"),
        ("gain", "inf", "gain = inf"),
        ("count", "65", "count = 65: expected a whole number from 1 to 64"),
        ("count", "2.5", "count = '2.5': expected a whole number"),
        ("count", "9" * 5000, r"count = '999.*\.\.\.: expected a whole number"),
        ("mode", "march9", "expected one of march, rgs09; did you mean 'march'?"),
        ("soft", "maybe", "expected true or false"),
        ("size", "5", "size = '5': expected WIDTHxHEIGHT .* each from 1 to 16 px"),
        ("size", "0x5", "size"),
        ("size", "-5x5", "size"),
        ("size", "5.5x5", "size"),
        ("size", "17x1", "size"),
        ("cuont", "3", "did you mean 'count'?"),
    ],
)
def test_wrong_values_are_refused_with_what_is_valid(name, text, said):
    with pytest.raises(SettingError, match=said.replace("?", r"\?")):
        parse(Example, name, text)


def test_check_names_the_field():
    with pytest.raises(SettingError, match="count = 0"):
        check(Example(count=0))


@pytest.mark.parametrize(
    ("name", "value", "read"),
    [("radius", 2, 2.0), ("count", 3, 3), ("size", [4, 4], (4, 4)), ("soft", False, False)],
)
def test_values_of_files_become_values_of_fields(name, value, read):
    result = from_file(Example, name, value)
    assert result == read and type(result) is type(read)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("count", 3.0),
        ("count", True),
        ("count", "3"),
        ("soft", 1),
        ("size", [1, 2, 3]),
        ("size", [1.5, 2]),
        ("mode", 3),
        ("mode", ["march"]),
        ("radius", 10**400),
        ("radius", [1]),
        ("radius", None),
    ],
)
def test_files_are_held_to_the_type(name, value):
    with pytest.raises(SettingError, match=f"{name} = .*: expected"):
        from_file(Example, name, value)
