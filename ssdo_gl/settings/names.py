"""Which methods, estimators and images there are. Whatever lists them asks here."""

from __future__ import annotations

from importlib import import_module

from ssdo_gl.effects.methods import METHODS


def method_names() -> tuple[str, ...]:
    """Return every method."""
    return tuple(METHODS)


def estimators_of(method: str) -> tuple[str, ...]:
    """Return the estimators of a method, its default first; empty if it has none."""
    return METHODS[method].estimators if method in METHODS else ()


def estimator_names() -> tuple[str, ...]:
    """Return every estimator of any method."""
    return tuple(dict.fromkeys(name for m in method_names() for name in estimators_of(m)))


def is_reference(method: str) -> bool:
    """Return whether a method traces rays."""
    return METHODS[method].is_reference


def aov_names() -> tuple[str, ...]:
    """Return every image that can be asked for."""
    # The effects that have them rest on settings.
    names: tuple[str, ...] = import_module("ssdo_gl.effects.registry").image_names()
    return names
