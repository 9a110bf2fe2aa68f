"""From a name, a scene file or a model file to a Scene."""

from __future__ import annotations

import os
import tomllib
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from ssdo_gl import resources
from ssdo_gl.scene import decoders
from ssdo_gl.scene.builder import SceneBuilder
from ssdo_gl.scene.defaults import guessed_up, turned_up, up_on_earth
from ssdo_gl.scene.file_camera import camera_of_file, listed_names
from ssdo_gl.scene.formats import (
    Model,
    format_of,
    model_suffixes,
    read_description,
    read_model,
    scene_suffixes,
)
from ssdo_gl.scene.scene import Scene
from ssdo_gl.scene.scene_error import SceneError, check_type
from ssdo_gl.settings.fields import SettingError
from ssdo_gl.settings.loading import LoadOptions, load_options
from ssdo_gl.wording import suggestion


def load_scene(source: str | Path, options: LoadOptions | None = None, **choices: Any) -> Scene:
    """Load a scene.

    Parameters
    ----------
    source : str or Path
        A file of one of `formats.FORMATS`, or the name of a built-in scene.
    options : LoadOptions or None
        What is added to the file, and how it stands.
    **choices
        Fields of `LoadOptions`, e.g. ``light="studio"``, in place of `options`. The scene
        holds what the file does: a ground is laid if ``ground="auto"`` is among them.

    Raises
    ------
    SceneError, SettingError
        One line that names the file and key, the value, and what would be valid.
    """
    if options is None:
        options = replace(load_options(choices), is_bare="ground" not in choices)
    check_type("options", options, LoadOptions)
    check_type("scene", source, (str, os.PathLike), "name or path")
    text = str(source)
    path = Path(text)
    if is_scene(text):
        options.check_scene(text)
    kind = format_of(path)
    if kind is not None:
        read = kind.read_scene or _load_model
        try:
            return read(path, text, options)
        finally:
            decoders.release()
    names = builtin_names()
    if text in names:
        file = resources.folder("scenes") / f"{text}.toml"
        return read_description(
            file.read_text(encoding="utf-8"), f"scenes/{text}.toml", options=options
        )
    if text and (path.suffix or "/" in text or "\\" in text or os.path.lexists(text[:1024])):
        valid = ", ".join((*scene_suffixes(), *model_suffixes()))
        what = "is a folder: " if os.path.isdir(text[:1024]) else ""
        raise SceneError(f"{text[:200]}: {what}expected a file ending in one of {valid}")
    shown = text if len(text) <= 60 else f"{text[:57]}..."
    raise SceneError(f"no built-in scene is called {shown!r}{suggestion(text, names)}")


def is_scene(source: str) -> bool:
    """Return whether it names a scene file or a built-in scene, and no model."""
    kind = format_of(Path(source))
    return source in builtin_names() if kind is None else kind.read_scene is not None


def builtin_names() -> list[str]:
    """Return the names of the built-in scenes, sorted."""
    folder = resources.folder("scenes")
    return sorted(
        file.name.removesuffix(".toml") for file in folder.iterdir() if file.name.endswith(".toml")
    )


@cache
def builtin_scenes() -> dict[str, tuple[str, str]]:
    """Return title and purpose of each built-in scene."""
    texts = {
        name: (resources.folder("scenes") / f"{name}.toml").read_text(encoding="utf-8")
        for name in builtin_names()
    }
    tables = {name: tomllib.loads(text) for name, text in texts.items()}
    return {n: (table["title"], " ".join(table["purpose"].split())) for n, table in tables.items()}


def _load_model(path: Path, source: str, options: LoadOptions) -> Scene:
    model = read_model(path, source, options.normals, options.crease_angle)
    builder = SceneBuilder(source, options)
    objects = model.add_to(builder)
    says_up = bool(model.cameras or model.lights or any(item.motion for item in objects))
    of_earth = None
    if options.up is None and objects and not says_up:
        of_earth = up_on_earth(builder.surfaces._replace(objects=objects))
    if of_earth is not None:
        builder.note(
            "up is away from the earth's centre, as coordinates are the earth's: --up y leaves it"
        )
        objects = turned_up(objects, of_earth)
    elif (options.up or _guessed_up(path, model, builder)) == "z":
        if says_up:
            raise SettingError(f"up = 'z': {source} has a camera, lights or motion, which say +y")
        objects = turned_up(objects, (0.0, 0.0, 1.0))
    for item in objects:
        builder.add(item)
    builder.lights += model.lights
    which = 0 if options.camera is None else options.camera
    seen = None
    if model.cameras or options.camera is not None:
        seen = camera_of_file(model.cameras, which, source)
    if len(model.cameras) > 1 and options.camera is None and not options.frames_all:
        builder.note(f"seen from the first of the file's cameras: {listed_names(model.cameras, 6)}")
    scene = builder.build(
        Scene,
        None if seen is None else seen.camera,
        None,
        exposure=None,
        camera_motion=None if seen is None else seen.motion,
        title=path.stem,
    )
    return replace(scene, cameras=tuple(model.cameras))


def _guessed_up(path: Path, model: Model, builder: SceneBuilder) -> str:
    """Return the axis that points up, and note what tells."""
    kind = format_of(path)
    if kind is None or (kind.scan_up is None and not kind.may_lie):
        return "y"
    up, why = guessed_up(model.meshes, kind.scan_up or "y")
    if kind.scan_up is None:
        if up == "z":
            builder.note(
                f"up is +y, the custom of its format; if that is a side ({why}), --up z turns it"
            )
        return "y"
    builder.note(f"up is +{up}, guessed ({why}): --up {'y' if up == 'z' else 'z'} turns it")
    return up
