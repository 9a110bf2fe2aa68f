"""Settings that have no effect on what is asked for: why, and with which methods they have one.

Read off the effects: a method uses what the passes of its effects declare.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ssdo_gl.effects.effect import Effect
from ssdo_gl.effects.registry import effects
from ssdo_gl.effects.tables import SurfaceCache
from ssdo_gl.passes.edge_aware_filter import FILTER, EdgeAwareFilterSettings
from ssdo_gl.passes.temporal import TEMPORAL
from ssdo_gl.settings.estimators import ESTIMATORS
from ssdo_gl.settings.fields import SettingError, describe
from ssdo_gl.settings.methods import METHODS
from ssdo_gl.settings.settings import Settings


def idle_because(settings: Settings, name: str, images: Sequence[str] = ("beauty",)) -> str:
    """Return in which circumstances a setting has no effect; empty if it may have one.

    Parameters
    ----------
    settings : Settings
        The method in use, and how lights are shadowed.
    name : str
        A field of Settings, or ``pass.field``.
    images : sequence of str
        What is asked for, as ``--aov`` names it.
    """
    return _idle_with_method(settings.method, name, images) or _idle_with_others(settings, name)


def idle_in_pictures(
    settings: Settings, name: str, images: Sequence[str], *, is_scene_read: bool = True
) -> str:
    """Return in which circumstances a setting has no effect on pictures that are drawn once.

    Parameters
    ----------
    is_scene_read : bool
        Whether `settings` holds what the scene asks for; else only the method counts.
    """
    if name.partition(".")[0] == TEMPORAL:
        return "on pictures: it belongs to the window or --serve"
    others = _idle_with_others(settings, name) if is_scene_read else ""
    return _idle_with_method(settings.method, name, images) or others


def check_used(
    settings: Settings, given: Mapping[str, Any], images: Sequence[str], *, is_scene_read: bool
) -> None:
    """Refuse flags without effect on pictures.

    Parameters
    ----------
    given : mapping
        Fields of Settings that flags gave, by name.

    Raises
    ------
    SettingError
        Names the flag and what it belongs to.
    """
    infos = describe(Settings)
    flags = {name: infos[name].flag for name in given if name != "overrides"}
    flags |= {key: f"{infos['overrides'].flag} {key}" for key in given.get("overrides", {})}
    for name, flag in flags.items():
        reason = idle_in_pictures(settings, name, images, is_scene_read=is_scene_read)
        if reason:
            raise SettingError(f"{flag} has no effect {reason}")


def _idle_with_method(method: str, name: str, images: Sequence[str]) -> str:
    users = _users(name)
    able = [m for m in METHODS if any(_takes_part(effect, m, images) for effect in users)]
    idle = bool(users) and method not in able
    return f"with method {method}: it belongs to {_listed(able)}" if idle else ""


def _idle_with_others(settings: Settings, name: str) -> str:
    """Return which other setting leaves a setting without effect."""
    pass_name = name.partition(".")[0]
    is_of_rays = name == "shadow_rays" or pass_name == "traced_shadows"
    if is_of_rays and settings.chosen_shadows != "traced":
        return "without traced shadows: it belongs to --shadows traced"
    if pass_name == "shadow_map" and settings.chosen_shadows != "map":
        return "without shadow maps: it belongs to --shadows map"
    estimators = [settings.chosen_estimator]
    estimators += [value for key, value in settings.overrides.items() if ".estimator" in key]
    if name == "steps" and not any(ESTIMATORS[e].takes_steps for e in estimators):
        able = [e for e in METHODS[settings.method].estimators if ESTIMATORS[e].takes_steps]
        return f"with estimator {estimators[0]}: it belongs to {_listed(able)}"
    return ""


def _users(name: str) -> list[Effect]:
    """Return the effects that a setting belongs to; empty: it belongs to all, or to none."""
    pass_name, _, field = name.rpartition(".")
    if name == "shadows" or pass_name == "shadow_map":
        pass_name = "traced_shadows"
    if pass_name == SurfaceCache.name:
        return [effect for effect in effects() if effect.reads_surface_cache]
    if TEMPORAL in (name, pass_name):
        return [effect for effect in effects() if effect.looks_around]
    if name == "combine":
        return [effect for effect in effects() if type(effect).occlusion is not Effect.occlusion]
    if name == "max_error":
        # Of a reference it ends the rays, of other methods it chooses the rest.
        return []
    return [
        effect
        for effect in effects()
        if effect.methods
        for of_pass, declared in effect.settings.items()
        if of_pass == pass_name
        or (pass_name == FILTER and issubclass(declared, EdgeAwareFilterSettings))
        or (not pass_name and field in describe(declared))
    ]


def _takes_part(effect: Effect, method: str, images: Iterable[str]) -> bool:
    """Return whether picture or images may need an effect, by a method."""
    shown = {*effect.images, *(term.name for term in effect.terms)}
    return method in effect.methods or (method in effect.shown_by and bool(shown & {*images}))


def _listed(names: Sequence[str]) -> str:
    return " or ".join(filter(None, (", ".join(names[:-1]), names[-1])))
