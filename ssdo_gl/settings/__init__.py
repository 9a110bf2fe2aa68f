"""What a user may choose: declared once, checked and written here."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from ssdo_gl.settings.settings import Combine, Settings

if TYPE_CHECKING:
    AOVS: tuple[str, ...]


def __getattr__(name: str) -> Any:
    """Return the names of all images; the effects that have them rest on this package."""
    if name != "AOVS":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return import_module("ssdo_gl.effects.registry").image_names()
