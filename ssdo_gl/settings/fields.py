"""Settings as data: each declared once, with default, unit, range and effect.

Whatever reads, checks, shows or writes a setting - flags, scene files, presets, panel,
documentation - asks the `SettingInfo` of its field and keeps no list of its own.
"""

from __future__ import annotations

import dataclasses
import inspect
import numbers
import re
import textwrap
import types
import typing
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

from ssdo_gl.user_error import UserError
from ssdo_gl.wording import suggestion

Choices = tuple[str | float, ...]
COLOR_CODE = "#[0-9a-fA-F]{6}"
# Shaders compute in float32; what lies beyond would arrive there as infinity.
FLOAT32_MAX = 3.4028234e38
# A value that the program chooses, where texts and files name it.
NONE = "none"
# More characters of a value than this say nothing more about what is wrong with it.
_SHOWN_CHARACTERS = 60


class SettingError(UserError, ValueError):
    """A setting that does not exist or whose value is out of range."""


class Kind(Enum):
    """What values a setting has; the value is how a message calls them."""

    BOOLEAN = "true or false"
    INTEGER = "a whole number"
    NUMBER = "a number"
    TEXT = "text"
    SIZE = "width and height"
    MAPPING = "a table"


@dataclass(frozen=True)
class SettingInfo:
    """All there is to know about one setting.

    Attributes
    ----------
    unit : str
        Empty for pure numbers.
    low, high : float or None
        Inclusive range, for sizes of each side; None: as far as float32 goes.
    doc : str
        The effect in one sentence.
    choices : tuple
        The only valid values, or empty.
    is_color : bool
        Whether ``#rrggbb`` is valid besides the choices.
    also : tuple of float
        Numbers outside the range that are valid, too: 0 or infinity.
    slider_high : float or None
        How far the panel's slider goes where `high` is too far for a hand.
    metavar : str
        What stands for the value in ``--help``.
    bare : str
        What the flag means alone, without a value; empty: it needs one.
    flag_name : str
        The flag's name where it is not that of the field.
    in_scene : bool
        Whether a scene's ``[render]`` table may hold it.
    group : str
        The heading under which ``--help`` lists it.
    modes : frozenset of str
        Where it has an effect (`modes.MODES`); a flag is refused elsewhere.
    is_quality : bool
        Whether it belongs to a preset; size and antialiasing are the window's business.
    name, kind, is_optional
        Of the field, filled in by `describe`. Optional: may be left to a default (None).
    """

    default: Any
    unit: str = ""
    low: float | None = None
    high: float | None = None
    doc: str = ""
    choices: Choices = ()
    is_color: bool = False
    also: tuple[float, ...] = ()
    slider_high: float | None = None
    metavar: str = ""
    bare: str = ""
    flag_name: str = ""
    in_scene: bool = True
    group: str = ""
    modes: frozenset[str] = frozenset()
    is_quality: bool = True
    name: str = ""
    kind: Kind = Kind.TEXT
    is_optional: bool = False

    @property
    def flag(self) -> str:
        """The command-line flag of a setting of the whole rendering."""
        return f"--{(self.flag_name or self.name).replace('_', '-')}"

    @property
    def range_text(self) -> str:
        """The range in words, e.g. ``from 1 to 1024 px``; empty where there is none."""
        ends = (("from", self.low), ("to", self.high))
        numbers = [f"{word} {number_text(end)}" for word, end in ends if end is not None]
        also = " or ".join(number_text(number) for number in self.also)
        if self.high is None and also == "inf":
            numbers, also = [*numbers, "to inf"], ""
        text = " ".join([*numbers, self.unit]).strip()
        return f"{text}, or {also}" if also else text

    @property
    def expected(self) -> str:
        """What would be valid, for messages."""
        if self.choices:
            listed = ", ".join(value_text(choice) for choice in self.choices)
            return f"one of {listed}" + (", or #rrggbb" if self.is_color else "")
        if self.kind is Kind.SIZE:
            pair = "[width, height] in a file, (width, height) in Python"
            return f"WIDTHxHEIGHT as a flag, {pair}, each {self.range_text}"
        is_number = self.kind in (Kind.INTEGER, Kind.NUMBER)
        return f"{self.kind.value} {self.range_text if is_number else ''}".rstrip()

    def allows(self, value: Any) -> bool:
        """Return whether `value` is valid."""
        if value is None:
            return self.is_optional
        if isinstance(value, bool) != (self.kind is Kind.BOOLEAN):
            return False
        if self.choices:
            if self.is_color and isinstance(value, str) and re.fullmatch(COLOR_CODE, value):
                return True
            return isinstance(value, (str, float, int)) and value in self.choices
        if self.kind is Kind.SIZE:
            sides = value if isinstance(value, tuple) and len(value) == 2 else ("",)
            return all(isinstance(n, numbers.Integral) and self._in_range(n) for n in sides)
        if self.kind is Kind.INTEGER:
            return isinstance(value, numbers.Integral) and self._in_range(value)
        if self.kind is Kind.NUMBER:
            return isinstance(value, numbers.Real) and self._in_range(value)
        return isinstance(value, {Kind.TEXT: str, Kind.MAPPING: Mapping}.get(self.kind, bool))

    def _in_range(self, value: Any) -> bool:
        """Whether a number is in range, or named beside it; never NaN."""
        low = -FLOAT32_MAX if self.low is None else self.low
        high = FLOAT32_MAX if self.high is None else self.high
        return bool(low <= value <= high) or value in self.also

    def fault(self, value: Any) -> str:
        """Return the line that refuses `value`: what it is and what would be valid."""
        names = [choice for choice in self.choices if isinstance(choice, str)]
        hint = suggestion(value, names, lists=False) if isinstance(value, str) else ""
        return f"{self.name} = {shown(value)}: expected {self.expected}{hint}"


class Unset:
    """Marks a value that nobody chose: a default, to which a scene's setting is preferred.

    It compares, hashes and computes as the plain value that it is.
    """


class _UnsetText(str, Unset):
    __slots__ = ()


class _UnsetInteger(int, Unset):
    pass


class _UnsetNumber(float, Unset):
    pass


class _UnsetPair(tuple[int, int], Unset):
    pass


_UNSET: dict[type, type] = {
    str: _UnsetText,
    int: _UnsetInteger,
    float: _UnsetNumber,
    tuple: _UnsetPair,
}


def setting(
    default: Any,
    doc: str,
    *,
    unit: str = "",
    low: float | None = None,
    high: float | None = None,
    choices: Choices = (),
    yields: bool = False,
    **more: Any,
) -> Any:
    """Declare a field of a settings dataclass with its unit, range and effect.

    Parameters
    ----------
    yields : bool
        Whether a value that was not given is marked as `Unset`.
    **more
        Further attributes of `SettingInfo`.
    """
    info = SettingInfo(default, unit, low, high, doc, choices, **more)
    kind = _UNSET.get(type(default)) if yields else None
    return dataclasses.field(
        default=default if kind is None else kind(default), metadata={"info": info}
    )


def describe(settings_class: type[Any]) -> dict[str, SettingInfo]:
    """Return name -> SettingInfo of every setting of a settings dataclass."""
    if settings_class not in _DESCRIBED:
        _DESCRIBED[settings_class] = _described(settings_class)
    return _DESCRIBED[settings_class]


# Checking settings once a frame must not read type hints each time.
_DESCRIBED: dict[type[Any], dict[str, SettingInfo]] = {}


def _described(settings_class: type[Any]) -> dict[str, SettingInfo]:
    hints = typing.get_type_hints(settings_class)
    infos = {}
    for field in dataclasses.fields(settings_class):
        if "info" in field.metadata:
            kind, is_optional = _kind_of(hints[field.name])
            info: SettingInfo = field.metadata["info"]
            infos[field.name] = replace(info, name=field.name, kind=kind, is_optional=is_optional)
    return infos


def _kind_of(wanted: Any) -> tuple[Kind, bool]:
    parts = [wanted]
    # Whether `A | None` is one or the other depends on what A is.
    if isinstance(wanted, types.UnionType) or typing.get_origin(wanted) is typing.Union:
        parts = [part for part in typing.get_args(wanted) if part is not type(None)]
    kinds = {bool: Kind.BOOLEAN, int: Kind.INTEGER, float: Kind.NUMBER, tuple: Kind.SIZE}
    plain = typing.get_origin(parts[0]) or parts[0]
    if plain in (str, typing.Literal):
        return Kind.TEXT, parts[0] is not wanted
    return kinds.get(plain, Kind.MAPPING), parts[0] is not wanted


def documented(settings_class: type[Any]) -> None:
    """Add range, default and effect of each setting to what ``help()`` shows of the class."""
    lines = [inspect.cleandoc(settings_class.__doc__ or "")]
    if "\nAttributes\n" not in lines[0]:
        lines.append("\nAttributes\n----------")
    for name, info in describe(settings_class).items():
        indent = " " * 4
        lines.append(f"{name} : {info.expected}, default {info.default!r}")
        lines.append(
            textwrap.fill(f"{info.doc}.", 90, initial_indent=indent, subsequent_indent=indent)
        )
    settings_class.__doc__ = "\n".join(lines)


def info_of(settings_class: type[Any], name: str, what: str = "setting") -> SettingInfo:
    """Return the SettingInfo of a field.

    Raises
    ------
    SettingError
        If there is none; suggests the nearest name.
    """
    infos = describe(settings_class)
    if name not in infos:
        raise SettingError(f"unknown {what} {shown(name)}{suggestion(name, infos)}")
    return infos[name]


def check(settings: Any) -> None:
    """Raise SettingError naming the first field whose value is not valid.

    Numbers of other libraries are kept as Python's, which every file and shader takes.
    """
    for name, info in describe(type(settings)).items():
        given = getattr(settings, name)
        value = plain(given)
        if not info.allows(value):
            raise SettingError(info.fault(value))
        if value is not given:
            object.__setattr__(settings, name, value)


def plain(value: Any) -> Any:
    """Return a value with its numbers as Python's own: NumPy's are of other types."""
    if isinstance(value, str | int | float | Unset):
        return value
    if isinstance(value, numbers.Real):
        return int(value) if isinstance(value, numbers.Integral) else float(value)
    if isinstance(value, tuple):
        return tuple(map(plain, value))
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    return value


def values(settings: Any) -> dict[str, Any]:
    """Return the settings by name, for files."""
    return {name: getattr(settings, name) for name in describe(type(settings))}


def parse(settings_class: type[Any], name: str, text: str) -> Any:
    """Return `text` as the value of field `name`, checked for type and range."""
    info = info_of(settings_class, name)
    try:
        value = _converted(info, text.strip())
    except ValueError:
        raise SettingError(info.fault(text)) from None
    if not info.allows(value):
        raise SettingError(info.fault(value))
    return value


def from_file(settings_class: type[Any], name: str, value: Any) -> Any:
    """Return a value of a TOML or JSON file as that of field `name`, checked.

    Whole numbers stand for floats, too, and arrays of two for sizes.
    """
    info = info_of(settings_class, name)
    is_pair = isinstance(value, list) and info.kind is Kind.SIZE
    wanted: Any = tuple(value) if is_pair else value
    if value is None or not info.allows(wanted):
        raise SettingError(info.fault(value))
    return float(wanted) if info.kind is Kind.NUMBER else wanted


def _converted(info: SettingInfo, text: str) -> Any:
    """Return `text` as a value of the setting's kind; raises ValueError."""
    if info.kind is Kind.BOOLEAN:
        words = {"true": True, "1": True, "yes": True, "false": False, "0": False, "no": False}
        if text.lower() not in words:
            raise ValueError(text)
        return words[text.lower()]
    if info.kind is Kind.SIZE:
        match = re.fullmatch(r"(\d{1,9})[xX](\d{1,9})", text)
        if match is None:
            raise ValueError(text)
        return int(match[1]), int(match[2])
    if info.kind is Kind.INTEGER:
        return int(text)
    return float(text) if info.kind is Kind.NUMBER else text


def value_text(value: object) -> str:
    """Return a setting's value as a flag takes it."""
    if value is None:
        return NONE
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, tuple):
        return "x".join(str(n) for n in value)
    return number_text(value) if isinstance(value, float) else str(value)


def number_text(value: float) -> str:
    """Return a float in as few digits as say it to a relative 5e-15."""
    # Every decimal of 15 digits is a float64 of its own, and 0.1 + 0.2 still reads 0.3.
    return f"{value + 0.0:.15g}"


def shown(value: object) -> str:
    """Return a value as messages show it: on one line, and not all of a long one."""
    try:
        text = repr(value)
    except ValueError:
        return "a whole number of thousands of digits"
    except RecursionError:
        return "a value nested thousands deep"
    return text if len(text) <= _SHOWN_CHARACTERS else text[: _SHOWN_CHARACTERS - 3] + "..."
