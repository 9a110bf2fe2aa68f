"""Writes the command that renders what a window shows. The inverse of `options`. Pure."""

from __future__ import annotations

import dataclasses
import shlex
from collections.abc import Mapping
from typing import Any

from ssdo_gl.options.idle import idle_in_pictures
from ssdo_gl.options.resolve import settings_for, told, with_scene_settings
from ssdo_gl.scene.camera import PROJECTIONS, Camera
from ssdo_gl.settings import Settings, modes
from ssdo_gl.settings.fields import describe, number_text, value_text
from ssdo_gl.settings.loading import FIT, USUAL, LoadOptions


def command_line(
    source: str,
    settings: Settings,
    *,
    scene_settings: Mapping[str, Any],
    camera: Camera | None,
    loading: LoadOptions = USUAL,
    aov: str = "beauty",
    seconds: float = 0.0,
    out: str = "view.png",
) -> str:
    """Return a shell command that writes this view to `out` without a window.

    Parameters
    ----------
    source : str
        The scene as it was named on the command line.
    settings : Settings
        As the user chose them: what is None is left to the scene.
    scene_settings : mapping
        ``Scene.render``; what the scene itself asks for needs no flag.
    camera : Camera or None
        None: the scene's own.
    loading : LoadOptions
        How the scene was loaded.
    """
    words = ["ssdo-gl", source, "--snapshot", out]
    if aov != "beauty":
        words += ["--aov", aov]
    if camera is not None:
        words += ["--projection", PROJECTIONS[int(camera.height is not None)]]
        words += ["--camera", camera_text(camera)]
    elif loading.frames_all:
        words += ["--camera", FIT]
    elif loading.camera is not None:
        words += ["--camera", str(loading.camera)]
    words += loading_flags(loading)
    if seconds:
        words += ["--time", number_text(seconds)]
    words += settings_flags(settings, scene_settings, aov)
    return shlex.join(words)


def loading_flags(loading: LoadOptions) -> list[str]:
    """Return the flags that load a file in the same way."""
    words = []
    for name, value in loading.given().items():
        flag = describe(LoadOptions)[name].flag
        words += [flag] if value is True else [flag, value_text(value)]
    return words


def settings_flags(settings: Settings, scene_settings: Mapping[str, Any], aov: str) -> list[str]:
    """Return the flags that make `settings` from what a scene asks for.

    Those are left out that no picture, or not this one, takes notice of: they would be refused.
    """
    words, infos = [], describe(Settings)
    # The method as it is, even where it yields to the scene's.
    with_method = dataclasses.replace(settings, method=str(settings.method))
    held = with_scene_settings(with_method, scene_settings)
    for name, value in told(settings, scene_settings).items():
        is_usual = name == "method" and value == settings_for(scene_settings, {}).method
        is_of_pictures = modes.SNAPSHOT in infos[name].modes
        if not is_usual and is_of_pictures and not idle_in_pictures(held, name, (aov,)):
            words += [infos[name].flag, value_text(value)]
    for key, value in sorted(settings.overrides.items()):
        if not idle_in_pictures(held, key, (aov,)):
            words += ["--set", f"{key}={value_text(value)}"]
    return words


def camera_text(camera: Camera) -> str:
    """Return ``"px,py,pz tx,ty,tz fov"`` (or height), which ``--camera`` reads."""
    third = camera.fov_y if camera.height is None else camera.height
    groups = (camera.position, camera.target, (third,))
    return " ".join(",".join(number_text(n) for n in group) for group in groups)
