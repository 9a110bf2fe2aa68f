"""What a caller asks to have rendered, checked: images of a scene, from a camera."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from numbers import Integral
from pathlib import Path
from typing import Any

from ssdo_gl.effects.registry import effects, image_names
from ssdo_gl.options.resolve import settings_for
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.scene.scene_error import check_type
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import SettingError, describe, plain, shown
from ssdo_gl.settings.loading import LoadOptions, load_options
from ssdo_gl.wording import suggestion


def checked_images(wanted: Iterable[str], frames: int = 1) -> tuple[str, ...]:
    """Return the images that are asked for, each once; raises SettingError, on `frames` too."""
    if not isinstance(frames, Integral) or frames < 1:
        raise SettingError(f"frames = {frames!r}: expected a whole number from 1")
    if isinstance(wanted, str) or not hasattr(wanted, "__iter__"):
        raise SettingError(f"images = {shown(wanted)}: expected a list of names")
    names, known = tuple(wanted), (*image_names(), "display")
    for name in names:
        if name not in known:
            hint = suggestion(str(name), known, lists=False)
            raise SettingError(f"image {shown(name)}: choose of {', '.join(known)}{hint}")
    return tuple(dict.fromkeys(names))


def images_of(aov: str | Iterable[str]) -> tuple[str, ...]:
    """Return the images that a caller names: one, several or ``all``; raises SettingError."""
    names = image_names() if aov == "all" else (aov,) if isinstance(aov, str) else tuple(aov)
    if not names:
        raise SettingError("aov: name at least one image")
    return checked_images(names)


def images_of_other_methods(wanted: Iterable[str], method: str) -> list[str]:
    """Return which of the images no effect of a method makes: they are the same everywhere."""
    of_others, of_method = set[str](), set[str]()
    for effect in effects():
        is_shown = method in effect.methods | effect.shown_by
        names = of_method if is_shown else of_others
        names.update(effect.images, (term.name for term in effect.terms))
    return [name for name in wanted if name in of_others - of_method]


def checked_camera(camera: object, name: str = "camera") -> Camera | None:
    """Return `camera` if it is one; None stands for the scene's; raises SettingError."""
    if not isinstance(camera, Camera | None):
        raise SettingError(f"{name}: expected a Camera, got {shown(camera)}")
    return camera


def asked_scene(
    source: str | Path | Scene, camera: Camera | str | int | None, given: Mapping[str, Any]
) -> tuple[Scene, Camera | None, Settings]:
    """Return the scene of `source`, the camera in place of its own, and the settings.

    Parameters
    ----------
    camera : Camera, str, int or None
        A name or number chooses one of a file's, which the scene then has.
    given : mapping
        Fields of `Settings`, over what the scene asks for, and of `LoadOptions` unless
        `source` is a Scene.

    Raises
    ------
    SceneError, SettingError
    """
    camera = plain(camera)
    if isinstance(source, Scene):
        return source, checked_camera(camera), settings_for(source.render, given)
    check_type("scene", source, (str, os.PathLike), "Scene, or its name or path")
    name = camera if isinstance(camera, str | int) else None
    place = checked_camera(camera) if name is None else None
    of_file = {key: value for key, value in given.items() if key in describe(LoadOptions)}
    rest = {key: value for key, value in given.items() if key not in of_file}
    options = load_options({**of_file, "camera": name})
    scene = load_scene(source, options)
    return scene, place, settings_for(scene.render, rest)
