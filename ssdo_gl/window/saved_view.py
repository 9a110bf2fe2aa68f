"""What a window shows, as a command, as a scene file, as a picture with data beside it."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.images.files import OutputError, png_bytes, write_atomically
from ssdo_gl.options.command_line import command_line
from ssdo_gl.options.preset_files import toml_value
from ssdo_gl.options.resolve import told
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment import (
    Environment,
    MapEnvironment,
    SkyEnvironment,
    kind_of,
)
from ssdo_gl.scene.lights import BLACK, KINDS, Light
from ssdo_gl.scene.load import builtin_names
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.material_edits import EDITED
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings.fields import describe, values
from ssdo_gl.settings.loading import FIT, USUAL, LoadOptions
from ssdo_gl.settings.settings import Settings
from ssdo_gl.version import __version__
from ssdo_gl.window.live import REFINE_FRAMES
from ssdo_gl.window.viewer import Viewer


def settings_shown(viewer: Viewer) -> Settings:
    """Return the settings that render what the left side shows at rest."""
    settings = dataclasses.replace(
        viewer.settings_of_side(0), size=viewer.picture_size, antialias=REFINE_FRAMES
    )
    if viewer.original.is_metered and not settings.gives("exposure"):
        # From another camera another one would be measured.
        settings = dataclasses.replace(settings, exposure=viewer.original.camera.exposure)
    if not settings.is_reference:
        # There the flag asks for other settings, which the window has found by now.
        settings = dataclasses.replace(settings, max_error=None)
    return settings


def view_command(
    viewer: Viewer,
    scene: Path | None = None,
    out: str = "view.png",
    settings: Settings | None = None,
) -> str:
    """Return the command line that renders what the left side shows at rest.

    Parameters
    ----------
    scene : Path or None
        What `save_scene` wrote of a scene that was edited.
    settings : Settings or None
        Instead of those that are shown.
    """
    settings = settings or settings_shown(viewer)
    loading = viewer.original.loading
    camera, asked = viewer.camera, viewer.loaded.render
    has_camera = scene is not None or camera is viewer.original.camera
    if scene is not None:
        # The file asks for what is shown.
        asked = {**asked, **render_table(settings_shown(viewer), asked)}
        loading = light_elsewhere(viewer)
    return command_line(
        viewer.source if scene is None else str(scene),
        settings,
        scene_settings=asked,
        camera=None if has_camera else camera,
        loading=loading,
        aov=viewer.view.aov,
        seconds=viewer.clock.seconds,
        out=out,
    )


def _base(viewer: Viewer) -> tuple[str, Path]:
    """Return what a scene file calls the present scene, and the folder it belongs in."""
    if viewer.source in builtin_names():
        return viewer.source, viewer.folder
    # A scene lies in the folder of what it is made from, and follows no links.
    source = Path(viewer.source).resolve()
    return source.name, source.parent


def _load_table(viewer: Viewer) -> dict[str, Any]:
    """Return how a scene file says that its base is read."""
    loading = viewer.original.loading
    table = loading.given()
    if loading.map_path is not None:
        folder, image = _base(viewer)[1].resolve(), Path(loading.map_path).resolve()
        table["light"] = image.relative_to(folder).as_posix() if folder in image.parents else ""
    camera = FIT if loading.frames_all else loading.camera
    return {n: v for n, v in {**table, "camera": camera}.items() if v not in (None, "")}


def light_elsewhere(viewer: Viewer) -> LoadOptions:
    """Return the light that a scene file cannot name: a map from another folder."""
    loading = viewer.original.loading
    is_named = loading.map_path is None or "light" in _load_table(viewer)
    return USUAL if is_named else LoadOptions(light=loading.light)


def save_scene(viewer: Viewer) -> Path:
    """Write a scene file that renders what the left side shows; return where.

    In the folder of what it is made from, of a built-in scene in that of the window; numbered,
    so that nothing is overwritten.

    Raises
    ------
    OutputError
        If nobody may write there.
    """
    base, folder = _base(viewer)
    path = free_stem(folder, Path(base).stem, ".toml")
    lights = [
        light if is_on else light.with_emitted(BLACK)
        for light, is_on in zip(viewer.lights, viewer.lights_on, strict=True)
    ]
    text = scene_text(
        base,
        viewer.loaded,
        load=_load_table(viewer),
        camera=viewer.camera,
        lights=lights,
        sources=viewer.light_sources,
        materials=viewer.original.materials,
        environment=viewer.original.environment,
        settings=settings_shown(viewer),
    )
    try:
        write_atomically(path, text.encode())
    except OutputError as error:
        raise OutputError(f"{error}; open a copy in a folder of your own to save it") from None
    return path


def picture_meta(viewer: Viewer, scene: Path | None) -> dict[str, Any]:
    """Return what made the picture, for the file beside it."""
    camera = viewer.camera
    sides = {"left": viewer.left, "right": viewer.right}
    return {
        "ssdo_gl": __version__,
        "command": view_command(viewer, scene),
        "scene": viewer.source if scene is None else str(scene),
        "seconds": viewer.clock.seconds,
        "camera": dataclasses.asdict(camera),
        "view": dataclasses.asdict(viewer.view),
        "settings": values(viewer.settings),
        "renderer": viewer.device.renderer,
        "gl_version": viewer.device.version,
        "samples": {
            name: side.image.sample_count for name, side in sides.items() if side is not None
        },
    }


def free_stem(folder: Path, stem: str, suffix: str) -> Path:
    """Return the first of ``STEM-001SUFFIX``, ``-002`` ... that does not exist yet."""
    number = 1
    while (path := folder / f"{stem}-{number:03d}{suffix}").exists():
        number += 1
    return path


def save_screenshot(
    folder: Path, stem: str, pixels: NDArray[np.uint8], meta: Mapping[str, Any]
) -> Path:
    """Write ``STEM-NNN.png`` and ``STEM-NNN.json``; return the former.

    Parameters
    ----------
    pixels : ndarray, shape (height, width, 3)
        sRGB, row 0 at the top.
    meta : mapping
        What made the picture; anything that JSON can hold.

    Raises
    ------
    OutputError
        If the folder cannot be written to.
    """
    path = free_stem(folder, stem, ".png")
    text = json.dumps(meta, indent=2, sort_keys=True, default=str) + "\n"
    write_atomically(path.with_suffix(".json"), text.encode())
    write_atomically(path, png_bytes(pixels))
    return path


def scene_text(
    base: str,
    original: Scene,
    *,
    load: Mapping[str, Any],
    camera: Camera,
    lights: Sequence[Light],
    sources: Sequence[int | None],
    materials: Sequence[Material],
    environment: Environment | None,
    settings: Settings,
) -> str:
    """Return TOML that makes of `base` what is shown.

    Parameters
    ----------
    base : str
        Name of a built-in scene, or of a file in the folder that the text will be in.
    original : Scene
        As `base` is loaded.
    load : mapping
        How it is: `LoadOptions` by name.
    lights : sequence of Light
        Those that are off send nothing.
    sources : sequence of int or None
        Which light of `original` each of them is; None: it was added.
    materials : sequence of Material
        In place of those of `original`; more are of added lights.
    settings : Settings
        Settings of single passes have no place in a scene.
    """
    lines = [f"base = {json.dumps(base)}"]
    if load:
        lines += ["", "[load]", *(f"{name} = {toml_value(load[name])}" for name in load)]
    lines += ["", "[camera]", *_camera_lines(camera)]
    if environment is not original.environment:
        lines += ["", "[environment]", *_environment_lines(environment)]
    lines += ["", "[render]", *_render_lines(settings, original.render)]
    for number, pair in enumerate(zip(original.materials, materials, strict=False), 1):
        lines += _material_lines(number, *pair)
    by_source = dict(zip(sources, lights, strict=True))
    for number, before in enumerate(original.lights):
        lines += _edit_lines(number + 1, before, by_source.get(number))
    for source, light in zip(sources, lights, strict=True):
        lines += [] if source is not None else ["", "[[light]]", *_light_lines(light)]
    return "\n".join(lines) + "\n"


def _camera_lines(camera: Camera) -> Iterator[str]:
    for name in ("position", "target", "up"):
        yield f"{name} = {_numbers(getattr(camera, name))}"
    if camera.height is not None:
        yield 'projection = "orthographic"'
        yield f"height = {_numbers(camera.height)}"
    for name in ("fov_y", "exposure"):
        yield f"{name} = {_numbers(getattr(camera, name))}"


def _environment_lines(environment: Environment | None) -> Iterator[str]:
    if isinstance(environment, SkyEnvironment):
        yield 'kind = "sky"'
        fields = dataclasses.asdict(environment.daylight)
    elif isinstance(environment, MapEnvironment):
        # The image is that of the base: only its turn can have been changed.
        fields = {"rotation_y": environment.rotation_y}
    else:
        yield f"kind = {json.dumps(kind_of(environment))}"
        fields = {} if environment is None else dataclasses.asdict(environment)
    yield from (f"{name} = {_numbers(value)}" for name, value in fields.items())


def render_table(settings: Settings, asked: Mapping[str, Any]) -> dict[str, Any]:
    """Return the [render] table that makes `settings` of what a base asks for."""
    infos = describe(Settings)
    return {n: value for n, value in told(settings, asked).items() if infos[n].in_scene}


def _edit_lines(number: int, before: Light, after: Light | None) -> Iterator[str]:
    """Tell how a light of the base has changed; None: it is gone."""
    if after == before:
        return
    yield from ("", "[[edit]]", f"light = {number}")
    if after is None:
        yield "remove = true"
        return
    if after.emitted != before.emitted:
        yield f"emitted = {_numbers(after.emitted)}"
    turned = [n for n in after.turned_fields if getattr(after, n) != getattr(before, n)]
    yield from (f"{name} = {_numbers(getattr(after, name))}" for name in turned)
    if after.place is not None and (turned or after.place != before.place):
        yield f"place = {_numbers(after.place)}"


def _material_lines(number: int, before: Material, after: Material) -> Iterator[str]:
    """Tell how a material of the base has changed."""
    values = {n: getattr(after, n) for n in EDITED if getattr(after, n) != getattr(before, n)}
    if values:
        yield from ("", "[[edit]]", f"material = {number}")
    yield from (f"{name} = {_numbers(value)}" for name, value in values.items())


def _light_lines(light: Light) -> Iterator[str]:
    yield f"kind = {json.dumps(next(n for n, kind in KINDS.items() if type(light) is kind))}"
    for name in ("name", "shadow", *light.keys()):
        value = getattr(light, name)
        yield f"{name} = {_numbers(value) if isinstance(value, tuple) else toml_value(value)}"


def _render_lines(settings: Settings, asked: Mapping[str, Any]) -> Iterator[str]:
    for name, value in render_table(settings, asked).items():
        yield f"{name} = {toml_value(list(value) if isinstance(value, tuple) else value)}"


def _numbers(value: float | Sequence[float]) -> str:
    """Return one number, or several, as floats of TOML."""
    if isinstance(value, (int, float)):
        return toml_value(float(value))
    return "[" + ", ".join(toml_value(float(number)) for number in value) + "]"
