"""From a name, a scene file or a model file to a Scene."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from ssdo_gl import resources
from ssdo_gl.scene import decoders
from ssdo_gl.scene.builder import SceneBuilder
from ssdo_gl.scene.formats import (
    format_of,
    model_suffixes,
    read_description,
    read_model,
    scene_suffixes,
)
from ssdo_gl.scene.scene import Scene, SceneError
from ssdo_gl.settings.loading import LoadOptions, load_options
from ssdo_gl.suggestion import suggestion


def load_scene(source: str | Path, options: LoadOptions | None = None, **choices: Any) -> Scene:
    """Load a scene.

    Parameters
    ----------
    source : str or Path
        A file of one of `formats.FORMATS`, or the name of a built-in scene.
    options : LoadOptions or None
        What is added to the file, and how it stands.
    **choices
        Fields of `LoadOptions`, e.g. ``light="studio"``, in place of `options`.

    Raises
    ------
    SceneError, SettingError
        One line that names the file and key, the value, and what would be valid.
    """
    options = options or load_options(choices)
    text = str(source)
    path = Path(text)
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
        raise SceneError(f"{text[:200]}: expected a file ending in one of {valid}")
    shown = text if len(text) <= 60 else f"{text[:57]}..."
    raise SceneError(f"no built-in scene is called {shown!r}{suggestion(text, names)}")


def builtin_names() -> list[str]:
    """Return the names of the built-in scenes, sorted."""
    folder = resources.folder("scenes")
    return sorted(
        file.name.removesuffix(".toml") for file in folder.iterdir() if file.name.endswith(".toml")
    )


def _load_model(path: Path, source: str, options: LoadOptions) -> Scene:
    model = read_model(path, source)
    builder = SceneBuilder(source, options)
    for item in model.add_to(builder):
        builder.add(item)
    builder.lights += model.lights
    return builder.build(
        model.camera,
        None,
        exposure=None,
        camera_motion=model.camera_motion,
        title=path.stem,
    )
