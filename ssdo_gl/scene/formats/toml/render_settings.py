"""The [render] table: the settings that a scene asks for; flags override them."""

from __future__ import annotations

from typing import Any

from ssdo_gl.scene.files import Table
from ssdo_gl.scene.scene import SceneError
from ssdo_gl.settings.fields import SettingError, describe, from_file
from ssdo_gl.settings.settings import Settings


def render_keys() -> tuple[str, ...]:
    """Return what a scene may set: the flags' names with underscores for dashes."""
    return tuple(name for name, info in describe(Settings).items() if info.in_scene)


def read_render_settings(table: Table | None) -> dict[str, Any]:
    """Return the settings by name, checked."""
    if table is None:
        return {}
    table.allow(*render_keys())
    try:
        settings = {name: from_file(Settings, name, value) for name, value in table.data.items()}
        Settings(**settings).checked()
        return settings
    except SettingError as error:
        raise SceneError(f"{table.where()} {error}") from None
