"""Writes a scene file that renders what a window shows: its base, and what was changed."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ssdo_gl.options.preset_files import toml_value
from ssdo_gl.options.resolve import told
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment import (
    Environment,
    MapEnvironment,
    SkyEnvironment,
    kind_of,
)
from ssdo_gl.scene.lights import KINDS, Light
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.material_edits import EDITED
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings.fields import describe
from ssdo_gl.settings.settings import Settings


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
