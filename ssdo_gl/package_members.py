"""What belongs to a family because its module lies in the family's folder."""

from __future__ import annotations

import inspect
import pkgutil
from collections.abc import Iterator
from importlib import import_module
from types import ModuleType


def modules_in(package: str) -> Iterator[ModuleType]:
    """Yield the modules and folders of a package, imported, by name."""
    path = import_module(package).__path__
    for name in sorted(info.name for info in pkgutil.iter_modules(path)):
        yield import_module(f"{package}.{name}")


def classes_in(package: str) -> Iterator[type]:
    """Yield the classes, but abstract ones, that modules of a package hold, each once."""
    values = dict.fromkeys(
        value
        for module in modules_in(package)
        for value in vars(module).values()
        if isinstance(value, type)
    )
    return (value for value in values if not inspect.isabstract(value))
