"""All effects, found in their folder; what others list of them is derived here."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from graphlib import TopologicalSorter
from typing import Any

from ssdo_gl.effects.effect import Effect
from ssdo_gl.package_members import classes_in
from ssdo_gl.passes.edge_aware_filter import FILTER, EdgeAwareFilterSettings
from ssdo_gl.passes.gbuffer import GBUFFER_IMAGES
from ssdo_gl.passes.temporal import TEMPORAL, TemporalSettings
from ssdo_gl.passes.tone_map import ToneMapSettings


def in_order(found: Iterable[Effect]) -> list[Effect]:
    """Return effects in the order in which they are decided, of terms in sums, and of images.

    Each comes after those that it names; what none names, a new one, after all that some
    name; and what shows nothing, but serves others, after all that do.
    """
    # Read backwards, so that what none names is free to come last.
    by_name = {effect.name: effect for effect in reversed([*found])}
    users: dict[str, list[str]] = {name: [] for name in by_name}
    for effect in by_name.values():
        for name in effect.after:
            users[name].append(effect.name)
    backwards = (by_name[name] for name in TopologicalSorter(users).static_order())
    return sorted(backwards, key=lambda effect: bool(effect.methods | effect.shown_by))[::-1]


def found_effects() -> list[Effect]:
    """Return one of each class of effects that the modules of `ssdo_gl.effects` define."""
    return in_order(cls() for cls in classes_in("ssdo_gl.effects") if issubclass(cls, Effect))


_EFFECTS = found_effects()


def effects() -> tuple[Effect, ...]:
    """Return all effects, those that others rest on first."""
    return tuple(_EFFECTS)


@contextmanager
def registered(effect: Effect) -> Iterator[None]:
    """Let `effect` be one of all for a while.

    Raises
    ------
    ValueError
        If there is an effect of that name.
    """
    before = effects()
    if effect.name in (known.name for known in before):
        raise ValueError(f"there is an effect called {effect.name!r}")
    _EFFECTS[:] = in_order((*before, effect))
    try:
        yield
    finally:
        _EFFECTS[:] = before


def term_names() -> tuple[str, ...]:
    """Return the names of all terms of the picture."""
    return tuple(dict.fromkeys(term.name for effect in _EFFECTS for term in effect.terms))


def image_names() -> tuple[str, ...]:
    """Return the names of all images that ``--aov`` knows, the picture first."""
    further = (name for effect in _EFFECTS for name in effect.images)
    return tuple(dict.fromkeys(("beauty", *term_names(), *further, *GBUFFER_IMAGES)))


def pass_settings() -> Mapping[str, type[Any]]:
    """Return the settings class of every pass that has one, by the pass' name."""
    own = {name: cls for effect in _EFFECTS for name, cls in effect.settings.items()}
    shared = {FILTER: EdgeAwareFilterSettings, TEMPORAL: TemporalSettings}
    return {**own, **shared, "tone_map": ToneMapSettings}
