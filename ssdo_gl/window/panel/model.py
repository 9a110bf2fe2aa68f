"""Which control edits which setting, with what range: read off the settings. Pure.

The command line checks values by the same `SettingInfo`, so the two cannot disagree.
"""

from __future__ import annotations

import dataclasses
import types
import typing
from dataclasses import dataclass
from enum import Enum
from typing import Any

from ssdo_gl.effects.registry import pass_settings
from ssdo_gl.settings import ESTIMATORS, Settings
from ssdo_gl.settings.fields import SettingInfo, describe

# Beyond this ratio of its ends, or without an upper one, a slider needs a logarithmic
# scale to be of use low down.
LOG_RATIO = 50.0
# How far a slider goes where a setting has no upper end; typing a number goes beyond.
OPEN_ENDS = {
    "radius": 4.0,
    "exposure": 10.0,
    "strength": 4.0,
    "thickness": 4.0,
    "bias": 0.1,
    "max_error": 1.0,
}
OPEN_END = 10.0
# The window has its own size and refines by itself; the rest has a place of its own.
_ELSEWHERE = ("method", "size", "overrides", "antialias")
# Where a method's choices are not in the metadata because they depend on other fields.
_CHOICES: dict[str, tuple[Any, ...]] = {
    "combine": ("ambient", "multiply", "report"),
    "resolution_scale": (1.0, 0.5),
}


class Widget(Enum):
    """What a control looks like."""

    CHOICE = "choice"
    CHECK = "check"
    INTEGER = "integer"
    NUMBER = "number"


@dataclass(frozen=True)
class ControlRow:
    """One control of the panel.

    Attributes
    ----------
    key : str
        Field of Settings, or ``pass.field``.
    label : str
    widget : Widget
    low, high : float
        Ends of the slider.
    is_log : bool
    choices : tuple
        Of a choice.
    is_optional : bool
        May be left to scene or method (None).
    hint : str
        Effect, unit, range and the flag that does the same.
    """

    key: str
    label: str
    widget: Widget
    low: float
    high: float
    is_log: bool
    choices: tuple[Any, ...]
    is_optional: bool
    hint: str

    @property
    def pass_name(self) -> str:
        """The pass whose setting it is; empty for one of the whole rendering."""
        return self.key.rpartition(".")[0]

    @property
    def field(self) -> str:
        """The field's own name."""
        return self.key.rpartition(".")[2]


def main_rows(settings: Settings) -> list[ControlRow]:
    """Return the controls of the rendering as a whole, in the order of `Settings`."""
    rows = [
        _row(name, info, Settings, f"--{name.replace('_', '-')}")
        for name, info in describe(Settings).items()
        if name not in _ELSEWHERE
    ]
    estimators = ESTIMATORS.get(settings.method, ())
    rows = [
        dataclasses.replace(row, choices=estimators, widget=Widget.CHOICE)
        if row.key == "estimator"
        else row
        for row in rows
    ]
    return [row for row in rows if row.widget is not Widget.CHOICE or row.choices]


def pass_rows() -> dict[str, list[ControlRow]]:
    """Return the controls of each pass; what `Settings` decides for all is left out."""
    common = set(describe(Settings)) | {"estimator"}
    result = {}
    for pass_name, settings_class in pass_settings().items():
        rows = [
            _row(f"{pass_name}.{name}", info, settings_class, f"--set {pass_name}.{name}=")
            for name, info in describe(settings_class).items()
            if name not in common
        ]
        if rows:
            result[pass_name] = rows
    return result


def value_of(settings: Settings, row: ControlRow) -> Any:
    """Return the present value of a control's setting."""
    if row.pass_name:
        default = describe(pass_settings()[row.pass_name])[row.field].default
        return settings.overrides.get(row.key, default)
    return getattr(settings, row.key)


def with_value(settings: Settings, row: ControlRow, value: Any) -> Settings:
    """Return `settings` with another value, checked.

    Raises
    ------
    SettingError
        If the value is out of its range.
    """
    if not row.pass_name:
        return dataclasses.replace(settings, **{row.key: value}).checked()
    overrides = dict(settings.overrides)
    default = describe(pass_settings()[row.pass_name])[row.field].default
    if value == default:
        overrides.pop(row.key, None)
    else:
        overrides[row.key] = value
    return dataclasses.replace(settings, overrides=overrides).checked()


def default_of(row: ControlRow) -> Any:
    """Return the value that the setting has when nobody chooses one."""
    settings_class = pass_settings()[row.pass_name] if row.pass_name else Settings
    return describe(settings_class)[row.field].default


def first_value(row: ControlRow) -> Any:
    """Return where an optional control begins once it is chosen."""
    if row.widget is Widget.CHOICE:
        return row.choices[0]
    low = max(row.low, row.high / 100.0)
    middle = (low * row.high) ** 0.5 if row.is_log else 0.5 * (row.low + row.high)
    return round(middle) if row.widget is Widget.INTEGER else middle


def _row(key: str, info: SettingInfo, settings_class: type[Any], flag: str) -> ControlRow:
    name = key.rpartition(".")[2]
    kinds = _kinds(settings_class, name)
    choices = tuple(c for c in info.choices if c is not None) or _CHOICES.get(name, ())
    low, high = _ends(name, info)
    if choices:
        widget = Widget.CHOICE
    elif bool in kinds:
        widget = Widget.CHECK
    elif int in kinds:
        widget = Widget.INTEGER
    else:
        widget = Widget.NUMBER if float in kinds else Widget.CHOICE
    numeric = widget in (Widget.INTEGER, Widget.NUMBER)
    is_wide = high > LOG_RATIO * low if low > 0.0 else low == 0.0 and info.high is None
    unit = f" ({info.unit})" if info.unit else ""
    label = name.replace("_", " ") + unit
    return ControlRow(
        key,
        label,
        widget,
        low,
        high,
        numeric and is_wide,
        choices,
        type(None) in kinds,
        _hint(info, flag),
    )


def _kinds(settings_class: type[Any], name: str) -> tuple[Any, ...]:
    wanted = typing.get_type_hints(settings_class)[name]
    if isinstance(wanted, types.UnionType) or typing.get_origin(wanted) is typing.Union:
        return typing.get_args(wanted)
    return (wanted,)


def _ends(name: str, info: SettingInfo) -> tuple[float, float]:
    high = info.high if info.high is not None else OPEN_ENDS.get(name, OPEN_END)
    low = info.low if info.low is not None else -high
    return float(low), float(high)


def _hint(info: SettingInfo, flag: str) -> str:
    parts = [info.doc]
    if info.low is not None or info.high is not None:
        low = "" if info.low is None else f"from {info.low:g} "
        high = "" if info.high is None else f"to {info.high:g} "
        parts.append(f"{low}{high}{info.unit}".strip())
    return "\n".join([*parts, flag])
