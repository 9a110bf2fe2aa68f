"""Reads what a user typed - flags, scene wishes, PASS.FIELD=VALUE - into Settings."""

from __future__ import annotations

import dataclasses
import difflib
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

from ssdo_gl.effects.registry import pass_settings
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import SettingError, describe, parse


def size_from_text(text: str) -> tuple[int, int]:
    """Return (width, height) of ``"1280x720"``; raises SettingError."""
    match = re.fullmatch(r"(\d{1,9})[xX](\d{1,9})", text.strip())
    if match is None:
        raise SettingError(f"--size {text!r}: expected WIDTHxHEIGHT, such as 1280x720")
    return int(match[1]), int(match[2])


def camera_from_text(text: str) -> dict[str, Any]:
    """Return position, target and, if given, fov_y of ``"px,py,pz tx,ty,tz [fov]"``."""
    parts = text.split()
    try:
        numbers = [tuple(float(n) for n in part.split(",")) for part in parts]
    except ValueError:
        numbers = []
    lengths = [len(group) for group in numbers]
    finite = all(math.isfinite(n) for group in numbers for n in group)
    if lengths not in ([3, 3], [3, 3, 1]) or not finite:
        raise SettingError(f'--camera {text!r}: expected "px,py,pz tx,ty,tz [fov_deg]"')
    if numbers[0] == numbers[1]:
        raise SettingError(f"--camera {text!r}: position and target are the same point")
    camera: dict[str, Any] = {"position": numbers[0], "target": numbers[1]}
    if len(numbers) == 3:
        camera["fov_y"] = numbers[2][0]
        if not 0.0 < camera["fov_y"] < 180.0:
            raise SettingError(f"--camera {text!r}: fov must be within 0 to 180 degrees")
    return camera


def overrides_from_text(items: Sequence[str]) -> dict[str, Any]:
    """Return {"pass.field": value} of ``PASS.FIELD=VALUE`` texts, checked for type and range."""
    result: dict[str, Any] = {}
    for item in items:
        key, equals, text = item.partition("=")
        pass_name, dot, name = key.strip().partition(".")
        if not equals or not dot:
            raise SettingError(f"--set {item!r}: expected PASS.FIELD=VALUE")
        known = pass_settings()
        if pass_name not in known:
            near = difflib.get_close_matches(pass_name, known, n=1)
            hint = f"did you mean {near[0]}?" if near else f"one of {', '.join(known)}"
            raise SettingError(f"--set {item!r}: unknown pass {pass_name!r}; {hint}")
        try:
            result[f"{pass_name}.{name}"] = parse(known[pass_name], name, text.strip())
        except SettingError as error:
            raise SettingError(f"--set {item!r}: {error}") from None
    return result


def settings_for(
    scene_wishes: Mapping[str, Any], flags: Mapping[str, Any], overrides: Sequence[str] = ()
) -> Settings:
    """Return checked Settings: flags win over the scene's wishes, those over defaults.

    Parameters
    ----------
    scene_wishes : mapping
        ``Scene.render``; names of Settings fields.
    flags : mapping
        Values of command-line flags; None where a flag was not given.
    overrides : sequence of str
        ``PASS.FIELD=VALUE`` texts.

    Raises
    ------
    SettingError
    """
    given = {name: value for name, value in flags.items() if value is not None}
    wishes = dict(scene_wishes)
    if "method" in given and given["method"] != wishes.get("method"):
        # A wish for an estimator belongs to the method the scene wished for.
        wishes.pop("estimator", None)
    unknown = [name for name in (*wishes, *given) if name not in describe(Settings)]
    if unknown:
        near = difflib.get_close_matches(unknown[0], describe(Settings), n=1)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise SettingError(f"unknown setting {unknown[0]!r}{hint}")
    settings = dataclasses.replace(Settings(), **{**wishes, **given})
    settings = dataclasses.replace(settings, overrides=overrides_from_text(overrides))
    try:
        return settings.checked()
    except SettingError as error:
        name, rest = str(error).split(" ", 1)
        if name not in given:
            raise
        raise SettingError(f"--{name.replace('_', '-')} {rest}") from None
