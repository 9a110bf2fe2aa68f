"""Which control edits which setting, with what range: read off the settings. Pure.

The command line checks values by the same `SettingInfo`, so the two cannot disagree.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

from ssdo_gl.effects.registry import pass_settings
from ssdo_gl.options.idle import idle_because
from ssdo_gl.options.pass_settings import override_info, overrides_from_table
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import Kind, SettingInfo, describe, info_of
from ssdo_gl.settings.methods import METHODS

# Beyond this ratio of its ends, or without an upper one, a slider needs a logarithmic
# scale to be of use low down.
LOG_RATIO = 50.0
# The lower end of a slider without 0, at least, as a part of the upper one.
SLIDER_SPAN = 1e-6
# How far a slider goes where neither a limit nor its declaration says.
OPEN_END = 10.0
# The window has its own size and refines by itself; the rest has a place of its own.
_ELSEWHERE = ("method", "size", "overrides", "antialias")


@dataclass(frozen=True)
class ControlRow:
    """One control of the panel.

    Attributes
    ----------
    key : str
        Field of Settings, or ``pass.field``.
    kind : Kind
        What values the control takes; text: one of `choices`.
    low, high : float
        Ends of the slider.
    is_optional : bool
        May be left to scene or method (None).
    hint : str
        Effect, unit, range and the flag that does the same.
    """

    key: str
    label: str
    kind: Kind
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
        _row(name, info, info.flag)
        for name, info in describe(Settings).items()
        if name not in _ELSEWHERE
    ]
    estimators = METHODS[settings.method].estimators
    rows = [
        dataclasses.replace(row, choices=estimators) if row.key == "estimator" else row
        for row in rows
    ]
    return [row for row in rows if row.kind is not Kind.TEXT or row.choices]


def pass_rows() -> dict[str, list[ControlRow]]:
    """Return the controls of each pass; what `Settings` decides for all is left out."""
    common = set(describe(Settings)) | {"estimator"}
    result = {}
    for pass_name, settings_class in pass_settings().items():
        rows = [
            _row(f"{pass_name}.{name}", info, f"--set {pass_name}.{name}=")
            for name, info in describe(settings_class).items()
            if name not in common
        ]
        if rows:
            result[pass_name] = rows
    return result


def ignored_because(settings: Settings, name: str, image: str = "beauty") -> str:
    """Return in which circumstances a setting has no effect on an image; empty if it has one."""
    if name == "max_error" and not settings.is_reference:
        return f"with method {settings.method}: a window measures the error of references alone"
    return idle_because(settings, name, (image,))


def value_of(settings: Settings, row: ControlRow) -> Any:
    """Return the present value of a control's setting."""
    if row.pass_name:
        return settings.overrides.get(row.key, default_of(row))
    return getattr(settings, row.key)


def with_value(settings: Settings, row: ControlRow, value: Any) -> Settings:
    """Return `settings` with another value, checked.

    Raises
    ------
    SettingError
        If the value is out of its range.
    """
    if not row.pass_name:
        # What is left to its default is the scene's to choose, once more.
        is_resolved = settings.is_resolved and value is not None
        changed = dataclasses.replace(settings, **{row.key: value}, is_resolved=is_resolved)
        return changed.checked()
    overrides = dict(settings.overrides)
    if value == default_of(row):
        overrides.pop(row.key, None)
    else:
        overrides |= overrides_from_table({row.key: value})
    return dataclasses.replace(settings, overrides=overrides).checked()


def default_of(row: ControlRow) -> Any:
    """Return the value that the setting has when nobody chooses one."""
    info = override_info(row.key) if row.pass_name else info_of(Settings, row.key)
    return info.default


def first_value(row: ControlRow) -> Any:
    """Return where an optional control begins once it is chosen."""
    if row.kind is Kind.TEXT:
        return row.choices[0]
    low = max(row.low, row.high / 100.0)
    middle = (low * row.high) ** 0.5 if row.is_log else 0.5 * (row.low + row.high)
    return round(middle) if row.kind is Kind.INTEGER else middle


def _row(key: str, info: SettingInfo, flag: str) -> ControlRow:
    kind = Kind.TEXT if info.choices else info.kind
    low, high = _ends(info)
    is_open = info.high is None or info.slider_high is not None
    is_wide = high > LOG_RATIO * low if low > 0.0 else low == 0.0 and is_open
    unit = f" ({info.unit})" if info.unit else ""
    return ControlRow(
        key,
        info.name.replace("_", " ") + unit,
        kind,
        low,
        high,
        kind in (Kind.INTEGER, Kind.NUMBER) and is_wide,
        info.choices,
        info.is_optional,
        "\n".join(part for part in (info.doc, info.range_text, flag) if part),
    )


def _ends(info: SettingInfo) -> tuple[float, float]:
    """Return the ends of a slider, which a typed number may exceed."""
    high = next(end for end in (info.slider_high, info.high, OPEN_END) if end is not None)
    low = -high if info.low is None else max(info.low, -high)
    low = 0.0 if 0.0 in info.also else low
    # A hand cannot aim within more decades.
    return max(float(low), SLIDER_SPAN * high) if low > 0.0 else float(low), float(high)
