"""What a user may choose: declared once, read, checked and written here."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ssdo_gl.settings import names
from ssdo_gl.settings.settings import Combine, Settings

__all__ = ["AOVS", "ESTIMATORS", "METHODS", "Combine", "Settings"]

METHODS = names.method_names()
# Estimators that each method understands; the first one is its default.
ESTIMATORS: Mapping[str, tuple[str, ...]] = {
    name: names.estimators_of(name) for name in METHODS if names.estimators_of(name)
}
if TYPE_CHECKING:
    AOVS: tuple[str, ...]


def __getattr__(name: str) -> Any:
    """Return the names of all images; the effects that have them rest on this package."""
    if name != "AOVS":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return names.aov_names()
