"""All effects, one row each; what others list of them is derived here."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from ssdo_gl.effects.back_layer import BackLayer
from ssdo_gl.effects.bounce import Bounce
from ssdo_gl.effects.direct import Direct
from ssdo_gl.effects.directional import Directional
from ssdo_gl.effects.effect import Effect
from ssdo_gl.effects.emission import Emission
from ssdo_gl.effects.far_field import FarField
from ssdo_gl.effects.references import ReferenceAo, ReferenceGi, ReferenceNear
from ssdo_gl.effects.reflections import Reflections
from ssdo_gl.effects.shadows import ShadowMaps, TracedShadows
from ssdo_gl.effects.ssao import Ssao
from ssdo_gl.effects.tables import EnvironmentImage, GlossTables, RayData, SurfaceCache
from ssdo_gl.passes.edge_aware_filter import FILTER, EdgeAwareFilterSettings
from ssdo_gl.passes.gbuffer import GBUFFER_IMAGES
from ssdo_gl.passes.temporal import TEMPORAL, TemporalSettings
from ssdo_gl.passes.tone_map import ToneMapSettings

# In the order in which they are decided: each may ask about those above it. It is also the
# order of the terms in sums, and of the images.
_EFFECTS: list[Effect] = [
    Emission(),
    Direct(),
    ShadowMaps(),
    TracedShadows(),
    # Before all that ask for the environment as rays need it.
    FarField(),
    EnvironmentImage(),
    Directional(),
    Ssao(),
    ReferenceAo(),
    ReferenceNear(),
    Bounce(),
    Reflections(),
    ReferenceGi(),
    # What several of those above may need comes last.
    BackLayer(),
    SurfaceCache(),
    RayData(),
    GlossTables(),
]


def effects() -> tuple[Effect, ...]:
    """Return all effects, those that others rest on first."""
    return tuple(_EFFECTS)


@contextmanager
def registered(effect: Effect) -> Iterator[None]:
    """Let `effect` be one of all for a while: after those it may rest on.

    Raises
    ------
    ValueError
        If there is an effect of that name.
    """
    names = [known.name for known in _EFFECTS]
    if effect.name in names:
        raise ValueError(f"there is an effect called {effect.name!r}")
    _EFFECTS.insert(names.index(BackLayer.name), effect)
    try:
        yield
    finally:
        _EFFECTS.remove(effect)


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
