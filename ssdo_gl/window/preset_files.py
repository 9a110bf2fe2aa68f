"""Writes settings to a file that ``--preset`` reads back. Pure but for the writing."""

from __future__ import annotations

import dataclasses
import json
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ssdo_gl.images.files import write_atomically
from ssdo_gl.settings import Settings
from ssdo_gl.settings.command_line import number_text
from ssdo_gl.settings.resolve import settings_for
from ssdo_gl.window.screenshot import free_stem

# The window's own business, and no quality of a rendering.
_LEFT_OUT = ("size", "antialias")


def preset_text(settings: Settings, wishes: Mapping[str, Any]) -> str:
    """Return TOML with every setting that differs from what a scene wishes for.

    Parameters
    ----------
    settings : Settings
    wishes : mapping
        ``Scene.render``.
    """
    usual = settings_for(wishes, {"method": settings.method})
    lines = ["# Read by: ssdo-gl SCENE --preset THIS_FILE", "", "[settings]"]
    lines.append(f"method = {_toml(settings.method)}")
    for field in dataclasses.fields(Settings):
        value = getattr(settings, field.name)
        if field.name in ("method", "overrides", *_LEFT_OUT) or value is None:
            continue
        if value != getattr(usual, field.name):
            lines.append(f"{field.name} = {_toml(value)}")
    if settings.overrides:
        lines += ["", "[settings.overrides]"]
        lines += [f"{_toml(key)} = {_toml(v)}" for key, v in sorted(settings.overrides.items())]
    return "\n".join(lines) + "\n"


def save_preset(folder: Path, settings: Settings, wishes: Mapping[str, Any]) -> Path:
    """Write ``preset-NNN.toml`` and return its path.

    Raises
    ------
    OutputError
        If the folder cannot be written to.
    """
    path = free_stem(folder, "preset", ".toml")
    write_atomically(path, preset_text(settings, wishes).encode())
    return path


def preset_fields(settings: Settings) -> dict[str, Any]:
    """Return the fields of `settings` that belong to a preset."""
    fields = dataclasses.fields(Settings)
    return {f.name: getattr(settings, f.name) for f in fields if f.name not in _LEFT_OUT}


def is_preset(path: str | Path) -> bool:
    """Return whether a file has a table of settings, as no scene has."""
    if Path(path).suffix != ".toml":
        return False
    try:
        return "settings" in tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError):
        return False


def _toml(value: object) -> str:
    if isinstance(value, float):
        text = number_text(value)
        # TOML tells floats from integers by their form, and so does `--preset`.
        return text if any(c in text for c in ".en") else f"{text}.0"
    # Strings, integers and booleans look alike in JSON and TOML.
    return json.dumps(value)
