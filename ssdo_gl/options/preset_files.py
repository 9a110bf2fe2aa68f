"""Settings in a file: what ``--preset`` reads and the window writes."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ssdo_gl.images.files import write_atomically
from ssdo_gl.options.pass_settings import overrides_from_table
from ssdo_gl.options.resolve import told
from ssdo_gl.settings.fields import (
    NONE,
    SettingError,
    describe,
    from_file,
    number_text,
    shown,
)
from ssdo_gl.settings.settings import Settings
from ssdo_gl.toml_text import read_toml


def read_preset(path: str | Path) -> dict[str, Any]:
    """Return the fields of Settings in a preset file, all of them checked.

    The file is TOML with names and values of settings, at the top or in a table
    ``settings``; those of single passes are in a table ``overrides`` of it.

    Raises
    ------
    SettingError
        One line naming the file and the key.
    """
    try:
        return _checked_fields(_read(Path(path)))
    except OSError as error:
        raise SettingError(f"--preset {path}: {error.strerror}") from None
    except ValueError as error:
        raise SettingError(f"--preset {path}: {error}") from None


def _read(path: Path) -> dict[str, Any]:
    """Return the tables of a TOML file; raises OSError, or ValueError in one line."""
    # A pipe would be waited for, and some devices never end.
    if os.path.exists(path) and not (path.is_file() or path.is_dir()):
        raise ValueError("is a pipe or device: expected a file")
    try:
        return read_toml(path.read_text(encoding="utf-8"))
    except UnicodeDecodeError as error:
        raise ValueError(f"byte {error.start} is not UTF-8 text") from None


def _checked_fields(data: Mapping[str, Any]) -> dict[str, Any]:
    table = data.get("settings", data)
    if not isinstance(table, dict):
        raise SettingError("settings: expected a table")
    beside = [key for key in data if key != "settings"]
    if table is not data and beside:
        raise SettingError(f"unknown key {shown(beside[0])} beside [settings]")
    fields: dict[str, Any] = {}
    for key, value in table.items():
        name = key.replace("-", "_")
        fields[name] = from_file(Settings, name, value)
    if "overrides" in fields:
        fields["overrides"] = _overrides(fields["overrides"])
    if "method" in fields:
        Settings(**fields).checked()
    return fields


def _overrides(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table of overrides: ``"bounce.strength" = 2`` or, nested, ``bounce.strength``."""
    flat: dict[str, Any] = {}
    for key, value in table.items():
        nested = value if isinstance(value, dict) else {"": value}
        flat |= {f"{key}.{name}".removesuffix("."): item for name, item in nested.items()}
    try:
        return overrides_from_table(flat)
    except SettingError as error:
        raise SettingError(f"overrides: {error}") from None


def preset_text(settings: Settings, scene_settings: Mapping[str, Any]) -> str:
    """Return TOML with every setting that differs from what a scene asks for.

    Parameters
    ----------
    scene_settings : mapping
        ``Scene.render``.
    """
    infos = describe(Settings)
    lines = ["# Read by: ssdo-gl SCENE --preset THIS_FILE", "", "[settings]"]
    for name, value in told(settings, scene_settings).items():
        if infos[name].is_quality:
            lines.append(f"{name} = {toml_value(value)}")
    if settings.overrides:
        lines += ["", "[settings.overrides]"]
        items = sorted(settings.overrides.items())
        lines += [f"{json.dumps(key)} = {toml_value(value)}" for key, value in items]
    return "\n".join(lines) + "\n"


def write_preset(path: Path, settings: Settings, scene_settings: Mapping[str, Any]) -> None:
    """Write what `preset_text` returns to a file.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    write_atomically(path, preset_text(settings, scene_settings).encode())


def preset_fields(settings: Settings) -> dict[str, Any]:
    """Return the fields of `settings` that belong to a preset."""
    infos = describe(Settings).items()
    return {name: getattr(settings, name) for name, info in infos if info.is_quality}


def is_preset(path: str | Path) -> bool:
    """Return whether a file has a table of settings, as no scene has."""
    if Path(path).suffix.lower() != ".toml":
        return False
    try:
        return "settings" in _read(Path(path))
    except (OSError, ValueError):
        return False


def toml_value(value: object) -> str:
    """Return a string, a number, a boolean or a list of them as TOML has it."""
    if isinstance(value, float):
        text = number_text(value)
        # TOML tells floats from integers by their form.
        return text if any(c in text for c in ".en") else f"{text}.0"
    # Strings, integers and booleans look alike in JSON and TOML.
    return json.dumps(NONE if value is None else value)
