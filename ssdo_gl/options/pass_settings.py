"""Settings of single passes: PASS.FIELD=VALUE, from the command line and from files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ssdo_gl.effects import registry
from ssdo_gl.graph.render_pass import RenderPass
from ssdo_gl.planning import walk  # noqa: F401 - defines the passes that no effect has
from ssdo_gl.settings.fields import (
    NONE,
    SettingError,
    SettingInfo,
    describe,
    from_file,
    info_of,
    parse,
    shown,
)
from ssdo_gl.wording import suggestion


def passes_without_settings() -> frozenset[str]:
    """Return the names of the other passes that ``--explain`` may show."""
    found, images = [RenderPass], (f"{name}_radiance" for name in registry.image_names())
    for kind in found:
        found += kind.__subclasses__()
    named = (kind.name for kind in found if "name" in vars(kind))
    return frozenset((*named, *images)) - registry.pass_settings().keys()


def override_info(key: str) -> SettingInfo:
    """Return what is known of ``pass.field``; raises SettingError."""
    pass_name, _, name = key.partition(".")
    return info_of(_settings_class(pass_name), name, f"setting of {pass_name}:")


def overrides_from_text(items: Sequence[str]) -> dict[str, Any]:
    """Return {"pass.field": value} of ``PASS.FIELD=VALUE`` texts, checked for type and range."""
    result: dict[str, Any] = {}
    for item in items:
        key, equals, text = item.partition("=")
        pass_name, dot, name = key.strip().partition(".")
        try:
            if not equals or not dot:
                raise SettingError("expected PASS.FIELD=VALUE")
            result[f"{pass_name}.{name}"] = _value(parse, pass_name, name, text)
        except SettingError as error:
            raise SettingError(f"--set {shown(item)}: {error}") from None
    return result


def overrides_from_table(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return {"pass.field": value} of a file's table, checked for type and range.

    Raises
    ------
    SettingError
        Names the key.
    """
    result: dict[str, Any] = {}
    for key, value in table.items():
        pass_name, dot, name = key.partition(".")
        if not dot:
            raise SettingError(f"{shown(key)}: expected a key like 'bounce.strength'")
        try:
            result[key] = _value(from_file, pass_name, name, value)
        except SettingError as error:
            raise SettingError(f"{pass_name}: {error}") from None
    return result


def _value(
    read: Callable[[type[Any], str, Any], Any], pass_name: str, name: str, value: Any
) -> Any:
    """Return a value as that of a setting; none leaves it to the program, as tables say."""
    owner = _settings_class(pass_name)
    takes_none = describe(owner)[name].is_optional if name in describe(owner) else False
    if takes_none and (value is None or (isinstance(value, str) and value.strip() == NONE)):
        return None
    try:
        return read(owner, name, value)
    except SettingError as error:
        raise SettingError(f"{error}, or {NONE}" if takes_none else str(error)) from None


def _settings_class(pass_name: str) -> type[Any]:
    known = registry.pass_settings()
    if pass_name in passes_without_settings():
        raise SettingError(f"the pass {pass_name} has no settings")
    if pass_name not in known:
        raise SettingError(f"unknown pass {shown(pass_name)}{suggestion(pass_name, known)}")
    return known[pass_name]
