"""Settings as data: one line each with default, unit, range and effect."""

from __future__ import annotations

import dataclasses
import difflib
import math
import types
import typing
from dataclasses import dataclass
from typing import Any


class SettingError(ValueError):
    """A setting that does not exist or whose value is out of range."""


@dataclass(frozen=True)
class SettingInfo:
    """What command line and panel show of one setting.

    Attributes
    ----------
    default : object
    unit : str
        Empty for pure numbers.
    low, high : float or None
        Inclusive range; None where unbounded or not a number.
    choices : tuple of str or None
        Valid values of a string setting, else empty. None: left to a default.
    doc : str
        The effect in one sentence.
    """

    default: Any
    unit: str
    low: float | None
    high: float | None
    choices: tuple[str | None, ...]
    doc: str


def setting(
    default: Any,
    doc: str,
    *,
    unit: str = "",
    low: float | None = None,
    high: float | None = None,
    choices: tuple[str | None, ...] = (),
) -> Any:
    """Declare a field of a settings dataclass with its unit, range and effect."""
    info = SettingInfo(default, unit, low, high, choices, doc)
    return dataclasses.field(default=default, metadata={"info": info})


def describe(settings_class: type[Any]) -> dict[str, SettingInfo]:
    """Return name -> SettingInfo of every field of a settings dataclass."""
    return {f.name: f.metadata["info"] for f in dataclasses.fields(settings_class)}


def check(settings: Any) -> None:
    """Raise SettingError naming the first field that is outside its range."""
    for name, info in describe(type(settings)).items():
        value = getattr(settings, name)
        if info.choices and value not in info.choices:
            valid = ", ".join(choice for choice in info.choices if choice is not None)
            raise SettingError(f"{name} = {value!r}: choose one of {valid}")
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            continue
        # An unbounded side is written as None, so infinity passes only where allowed.
        too_low = info.low is not None and not value >= info.low
        too_high = info.high is not None and not value <= info.high
        if math.isnan(value) or too_low or too_high:
            low = "-inf" if info.low is None else f"{info.low:g}"
            high = "inf" if info.high is None else f"{info.high:g}"
            valid = f"must be within {low} to {high} {info.unit}".rstrip()
            raise SettingError(f"{name} = {value!r}: {valid}")


def parse(settings_class: type[Any], name: str, text: str) -> Any:
    """Return `text` as the value of field `name`, checked for type and range."""
    infos = describe(settings_class)
    if name not in infos:
        near = difflib.get_close_matches(name, infos, n=1)
        hint = f"; did you mean {near[0]}?" if near else f"; choose one of {', '.join(infos)}"
        raise SettingError(f"unknown setting {name!r}{hint}")
    wanted = typing.get_type_hints(settings_class)[name]
    if isinstance(wanted, types.UnionType):
        wanted = next(t for t in typing.get_args(wanted) if t is not type(None))
    try:
        value = _convert(wanted, text)
    except ValueError:
        kind = getattr(wanted, "__name__", "text")
        raise SettingError(f"{name} = {text!r}: expected {kind}") from None
    check(dataclasses.replace(settings_class(), **{name: value}))
    return value


def _convert(wanted: Any, text: str) -> Any:
    if wanted is bool:
        known = {"true": True, "1": True, "yes": True, "false": False, "0": False, "no": False}
        if text.lower() not in known:
            raise ValueError(text)
        return known[text.lower()]
    if wanted in (int, float):
        return wanted(text)
    return text
