"""What a user may choose: declared once, read, checked and written here."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ssdo_gl.effects.methods import METHODS as _METHODS
from ssdo_gl.settings.settings import Combine, Settings

__all__ = ["AOVS", "ESTIMATORS", "METHODS", "Combine", "Settings"]

METHODS = tuple(_METHODS)
# Estimators that each method understands; the first one is its default.
ESTIMATORS: Mapping[str, tuple[str, ...]] = {
    name: method.estimators for name, method in _METHODS.items() if method.estimators
}
if TYPE_CHECKING:
    AOVS: tuple[str, ...]


def __getattr__(name: str) -> Any:
    """Return the names of all images; the effects that have them rest on this package."""
    if name != "AOVS":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return import_module("ssdo_gl.effects.registry").image_names()
