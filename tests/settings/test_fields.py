"""Settings carry their range, and a wrong value is refused with what would be right."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from ssdo_gl.settings.fields import SettingError, check, describe, parse, setting


@dataclass(frozen=True)
class Example:
    radius: float | None = setting(0.5, "reach", unit="scene units", low=0.0)
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
        ("radius", "-1", "must be within 0 to inf scene units"),
        ("radius", "nan", "must be within"),
        ("radius", "wide", "expected float"),
        ("count", "65", "must be within 1 to 64"),
        ("count", "2.5", "expected int"),
        ("mode", "guess", "choose one of march, rgs09"),
        ("soft", "maybe", "expected bool"),
        ("cuont", "3", "did you mean count?"),
    ],
)
def test_wrong_values_are_refused_with_what_is_valid(name, text, said):
    with pytest.raises(SettingError, match=said.replace("?", r"\?")):
        parse(Example, name, text)


def test_check_names_the_field():
    with pytest.raises(SettingError, match="count = 0"):
        check(Example(count=0))
