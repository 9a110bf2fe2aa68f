"""The [render] table: the scene's own wishes, which flags override."""

from __future__ import annotations

from typing import Any

from ssdo_gl.scene.scene import SceneError
from ssdo_gl.scene.table import Table
from ssdo_gl.settings.fields import SettingError, describe, from_file
from ssdo_gl.settings.settings import Settings


def wish_names() -> tuple[str, ...]:
    """Return what a scene may wish for: the flags' names with underscores for dashes."""
    return tuple(name for name, info in describe(Settings).items() if info.in_scene)


def read_wishes(table: Table | None) -> dict[str, Any]:
    """Return the wishes by name, checked."""
    if table is None:
        return {}
    table.allow(*wish_names())
    try:
        wishes = {name: from_file(Settings, name, value) for name, value in table.data.items()}
        Settings(**wishes).checked()
        return wishes
    except SettingError as error:
        raise SceneError(f"{table.where()} {error}") from None
