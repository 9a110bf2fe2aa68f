"""A scene that is another one with changes: the keys ``base`` and ``[[edit]]``."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from contextvars import ContextVar
from pathlib import Path
from typing import Any

from ssdo_gl.scene.builder import SceneBuilder
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.defaults import parallel
from ssdo_gl.scene.environment import (
    SUN,
    Environment,
    MapEnvironment,
    SkyEnvironment,
    sun_of,
    with_sun,
)
from ssdo_gl.scene.files import Table, contained_file
from ssdo_gl.scene.formats.toml.materials import file_beside
from ssdo_gl.scene.formats.toml.scene_tables import (
    read_camera,
    read_environment,
    read_height,
    read_light,
    read_render_settings,
)
from ssdo_gl.scene.light_edits import with_added_light, with_lights, without_light
from ssdo_gl.scene.lights import BLACK
from ssdo_gl.scene.material_edits import (
    EDITED,
    SHARES,
    edited_material,
    shows_light,
    with_edited,
)
from ssdo_gl.scene.scene import Scene
from ssdo_gl.scene.scene_error import SceneError
from ssdo_gl.settings.fields import SettingError, describe
from ssdo_gl.settings.loading import LoadOptions, load_options
from ssdo_gl.wording import suggestion

# What such a scene may hold; lights are added, objects and materials are those of its base.
BASED_KEYS = (
    "base",
    "load",
    "title",
    "purpose",
    "camera",
    "environment",
    "render",
    "edit",
    "light",
)
# A base may have a base.
MOST_BASES = 16
# One takes the place of the other.
_LIGHT = ("light", "no_default_light")
# The scene files that are being read: each is to be the base of the one before.
_followers: ContextVar[tuple[Path | None, ...]] = ContextVar("followers", default=())


def read_based_scene(top: Table, file: Path | None, options: LoadOptions) -> Scene:
    """Return the base of `top` as its other keys change it.

    Parameters
    ----------
    file : Path or None
        The scene file: the base is a built-in scene, or lies in its folder.

    Raises
    ------
    SceneError
        Naming the key, or what is wrong with the base.
    """
    top.allow(*BASED_KEYS)
    render = read_render_settings(top.table("render"))
    loading = _loading(top, file, options)
    base = _base(top, file, loading)
    builder = SceneBuilder(top.source, options)
    changes: dict[str, Any] = {
        "title": top.text("title", base.title),
        "purpose": top.text("purpose", base.purpose),
        "render": _merged(base.render, render),
        "environment": base.environment,
    }
    environment = top.table("environment")
    if environment is not None and "kind" in environment:
        without = environment.text("kind") == "none"
        read = read_environment
        changes["environment"] = None if without else read(environment, file, builder)
        base = _sunlit(base, changes["environment"])
    elif environment is not None:
        environment.allow("rotation_y")
        rotation = environment.number("rotation_y")
        if not isinstance(base.environment, MapEnvironment) or isinstance(
            base.environment, SkyEnvironment
        ):
            environment.fail("rotation_y", "the base has no map to turn: expected a kind, too")
        changes["environment"] = dataclasses.replace(base.environment, rotation_y=rotation)
        base = _sunlit(base, changes["environment"])
    table = top.table("camera")
    if table is not None:
        changes["camera"] = _camera(table, base, frames_all=options.frames_all)
        if "position" in table and not options.frames_all:
            changes |= {"is_framed": False, "camera_motion": None}
        if "exposure" in table:
            changes["metering_slack"] = None
    changes["notes"] = (*base.notes, *builder.notes)
    if loading.replaces_light and not options.replaces_light:
        # By the file, whose own that light is.
        changes |= {"added_light_count": 0, "has_added_sky": False}
    changes["loading"] = options
    return dataclasses.replace(_with_edits(top, base, builder), **changes)


def _sunlit(base: Scene, environment: Environment | None) -> Scene:
    """Return `base` with its sun as another environment has it."""
    sun = sun_of(environment)
    if sun is None:
        return base
    lights = with_sun(base.lights, sun)
    if sun_of(base.environment) is None and not any(light.name == SUN for light in lights):
        lights = (*lights, sun)
    return dataclasses.replace(base, lights=lights)


def _loading(top: Table, file: Path | None, options: LoadOptions) -> LoadOptions:
    """Return how the base is read: as ``[load]`` says, where flags say nothing."""
    table = top.table("load")
    if table is None:
        return options
    table.allow(*describe(LoadOptions), "camera")
    try:
        asked = load_options(table.data)
    except SettingError as error:
        raise SceneError(f"{table.where()} {error}") from None
    if asked.map_path is not None:
        asked = dataclasses.replace(asked, light=str(file_beside(table, "light", file)))
    if options.frames_all:
        asked = dataclasses.replace(asked, camera=None, frames_all=True)
    given = options.given()
    if any(name in given for name in _LIGHT):
        given |= {name: getattr(options, name) for name in _LIGHT}
    return dataclasses.replace(asked, is_bare=options.is_bare, **given)


def _base(top: Table, file: Path | None, options: LoadOptions) -> Scene:
    # Loading knows all formats, of which this is one.
    from ssdo_gl.scene.load import builtin_names, load_scene

    name = top.text("base")
    followers = (*_followers.get(), file)
    if len(followers) > MOST_BASES:
        top.fail("base", f"at most {MOST_BASES} scenes that follow from one another")
    token = _followers.set(followers)
    try:
        if name in builtin_names():
            return load_scene(name, options)
        if file is None or not Path(name).suffix:
            known = suggestion(name, builtin_names())
            top.fail("base", f"no built-in scene is called that{known}")
        base = contained_file(file, name, top.where("base"))
        if base in followers:
            top.fail("base", f"expected a scene that does not follow from {file.name} in turn")
        return load_scene(base, options)
    except SettingError as error:
        table = top.table("load")
        if table is None:
            raise
        raise SceneError(f"{table.where()} {error}") from None
    finally:
        _followers.reset(token)


def _merged(base: Mapping[str, Any], render: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings of both; another method has another estimator."""
    kept = dict(base)
    if render.get("method", base.get("method")) != base.get("method"):
        kept.pop("estimator", None)
    return {**kept, **render}


def _camera(table: Table, base: Scene, *, frames_all: bool) -> Camera:
    camera, fov_y, exposure = read_camera(table, base.camera)
    if camera is not None and not frames_all:
        return camera
    if frames_all:
        camera = base.framed(None, fov_y, exposure)
        is_parallel = read_height(table) is not None
        return parallel(base.surfaces(), camera, None) if is_parallel else camera
    camera = dataclasses.replace(base.camera, fov_y=fov_y, exposure=exposure)
    height = read_height(table)
    return camera if height is None else camera.orthographic(height or None)


def _with_edits(top: Table, base: Scene, builder: SceneBuilder) -> Scene:
    lights, removed = list(base.lights), list[int]()
    for table in top.tables("edit"):
        if "material" in table:
            base = _with_material(table, base)
            continue
        index = table.integer("light", None, 1, len(lights)) - 1
        light = lights[index]
        table.allow("light", "emitted", "place", "remove", *light.turned_fields)
        if table.boolean("remove", False):
            removed.append(index)
        # A direction is of unit length, an edge as long as the light.
        vectors = {n: table.direction(n) for n in light.direction_fields if n in table}
        vectors |= {n: table.vector(n) for n in light.edge_fields if n in table}
        light = light.turned_to(vectors)
        if "emitted" in table:
            light = light.with_emitted(table.color("emitted"))
        if "place" in table:
            if light.place is None:
                table.fail("place", f"a {light.kind} light has none")
            light = light.moved_to(table.vector("place"))
        lights[index] = light
    scene = with_lights(base, lights, [True] * len(lights))
    first = len(lights)
    for index in sorted(removed, reverse=True):
        # Those of one body go together.
        if index < first:
            scene, gone = without_light(scene, index)
            first = gone.start
    for table in top.tables("light"):
        read_light(table, builder)
    for light in builder.lights:
        scene = with_added_light(scene, light)
    return scene


def _with_material(table: Table, base: Scene) -> Scene:
    """Return the base with one of its materials changed."""
    index = table.integer("material", None, 1, len(base.materials)) - 1
    table.allow("material", *EDITED)
    values: dict[str, Any] = {name: table.number(name, 0.0, low=0.0, high=1.0) for name in SHARES}
    values["albedo"] = table.color("albedo", BLACK, 1.0)
    values["emission"] = table.color("emission", BLACK)
    values["ior"] = table.number("ior", 1.0, low=1.0)
    given = {name: value for name, value in values.items() if name in table}
    if "emission" in given and shows_light(base, index):
        table.fail("emission", "it is that of a light: expected an edit of the light")
    return with_edited(base, index, edited_material(base.materials[index], given))
