"""The [camera], [environment], [render] and [[light]] tables, and motions in any of them."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any, cast, get_args

from ssdo_gl.math3d import Vector
from ssdo_gl.scene.builder import SceneBuilder
from ssdo_gl.scene.camera import PROJECTIONS, Camera
from ssdo_gl.scene.environment import (
    ConstantEnvironment,
    Daylight,
    Environment,
    GradientEnvironment,
    sky,
    sun_apart,
    sun_note,
)
from ssdo_gl.scene.files import Table, read_radiance_map
from ssdo_gl.scene.formats.toml.materials import file_beside
from ssdo_gl.scene.lights import KINDS, Shadow
from ssdo_gl.scene.motion import Motion
from ssdo_gl.scene.scene_error import SceneError
from ssdo_gl.settings.fields import SettingError, describe, from_file
from ssdo_gl.settings.settings import LONGEST, MAX_EXPOSURE_EV, SHORTEST, Settings

MOTION_TABLE = "animate"
KEYS = ("spin", "pivot", "orbit", "orbit_center", "sway", "period")
# Seconds; at the largest time that may be asked for, the phase is still a number.
_SHORTEST_PERIOD = 1e-6
_ZERO: Vector = (0.0, 0.0, 0.0)


def read_motion(table: Table, center: Vector) -> Motion | None:
    """Return the motion of an object or light whose middle is `center`, if it has one.

    `spin` turns about `pivot`, which is `center` unless the file says otherwise.
    """
    animate = table.table(MOTION_TABLE)
    if animate is None:
        return None
    animate.allow(*KEYS)
    motion = Motion(
        spin=animate.vector("spin", _ZERO),
        orbit=animate.vector("orbit", _ZERO),
        pivot=animate.vector("pivot", center),
        orbit_center=animate.vector("orbit_center", _ZERO),
        sway=animate.vector("sway", _ZERO),
        period=animate.number("period", 4.0, low=_SHORTEST_PERIOD),
    )
    moves = any(motion.spin) or any(motion.orbit) or any(motion.sway)
    return motion if moves else None


def spins_in_place(table: Table) -> bool:
    """Return whether each copy of the object turns about its own middle."""
    animate = table.table(MOTION_TABLE)
    return animate is not None and "pivot" not in animate and any(animate.vector("spin", _ZERO))


# What a camera has that was not placed by a file.
USUAL_FOV_Y = 40.0
_SKY_KEYS: dict[str, tuple[str, ...]] = {
    "constant": ("radiance",),
    "gradient": ("zenith", "horizon", "ground"),
    "map": ("path", "rotation_y", "scale"),
    "sky": ("hour", "latitude", "day", "turbidity", "north"),
}
SHADOWS: tuple[str, ...] = get_args(Shadow)
_LIGHT_KEYS = ("kind", "name", "shadow", MOTION_TABLE)


def read_camera(table: Table, base: Camera | None = None) -> tuple[Camera | None, float, float]:
    """Return the camera (None if it has no position), its field of view and exposure.

    Parameters
    ----------
    base : Camera or None
        Gives field of view and exposure where the table has none.
    """
    usual = (USUAL_FOV_Y, 0.0) if base is None else (base.fov_y, base.exposure)
    table.allow("position", "target", "up", "fov_y", "exposure", "projection", "height")
    fov_y = table.number("fov_y", usual[0], low=0.0, high=180.0, open_ends=True)
    exposure = table.number("exposure", usual[1], low=-MAX_EXPOSURE_EV, high=MAX_EXPOSURE_EV)
    if "position" not in table:
        for key in ("target", "up"):
            if key in table:
                table.fail("position", f"a camera with {key!r} needs a position too")
        return None, fov_y, exposure
    position = table.vector("position")
    target = table.vector("target")
    if position == target:
        table.fail("target", "must not coincide with position")
    up = table.direction("up", (0.0, 1.0, 0.0))
    camera, height = Camera(position, target, up, fov_y, exposure), read_height(table)
    return camera if height is None else camera.orthographic(height or None), fov_y, exposure


def read_height(table: Table) -> float | None:
    """Return what parallel rays show; 0 if that is not said, None for a pinhole."""
    is_parallel = table.text("projection", PROJECTIONS[0], PROJECTIONS) != PROJECTIONS[0]
    if "height" not in table:
        return 0.0 if is_parallel else None
    if not is_parallel:
        table.fail("height", 'it belongs to projection = "orthographic"')
    return table.number("height", low=SHORTEST, high=LONGEST)


def read_environment(
    table: Table | None, file: Path | None, builder: SceneBuilder
) -> Environment | None:
    """Return the environment that the table describes, or None."""
    if table is None:
        return None
    kind = table.text("kind", choices=tuple(_SKY_KEYS))
    table.allow("kind", *_SKY_KEYS[kind])
    if kind == "constant":
        return ConstantEnvironment(table.color("radiance"))
    if kind == "gradient":
        return GradientEnvironment(
            table.color("zenith"), table.color("horizon"), table.color("ground")
        )
    if kind == "sky":
        return sky(_daylight(table))
    path = file_beside(table, "path", file)
    scale = table.number("scale", 1.0, low=0.0)
    image, note = read_radiance_map(path, table.where("path"), scale)
    environment = sun_apart(image, table.number("rotation_y", 0.0), path.name)
    for text in filter(None, (note, sun_note(environment))):
        builder.note(text)
    return environment


def _daylight(table: Table) -> Daylight:
    usual = Daylight()
    daylight = Daylight(
        hour=table.number("hour", usual.hour, low=0.0, high=24.0),
        latitude=table.number("latitude", usual.latitude, low=-90.0, high=90.0),
        day=table.number("day", usual.day, low=1.0, high=366.0),
        turbidity=table.number("turbidity", usual.turbidity, low=2.0, high=10.0),
        north=table.number("north", usual.north),
    )
    if not daylight.is_day:
        table.fail("hour", "an hour (solar time) at which the sun is above the horizon")
    return daylight


def render_keys() -> tuple[str, ...]:
    """Return what a scene may set: the flags' names with underscores for dashes."""
    return tuple(name for name, info in describe(Settings).items() if info.in_scene)


def read_render_settings(table: Table | None) -> dict[str, Any]:
    """Return the settings that a scene asks for, which flags override, by name, checked."""
    if table is None:
        return {}
    table.allow(*render_keys())
    try:
        settings = {name: from_file(Settings, name, value) for name, value in table.data.items()}
        Settings(**settings).checked()
        return settings
    except SettingError as error:
        raise SceneError(f"{table.where()} {error}") from None


def read_light(table: Table, builder: SceneBuilder) -> None:
    """Add the light of a table."""
    kind = KINDS[table.text("kind", choices=tuple(KINDS))]
    table.allow(*_LIGHT_KEYS, *kind.keys())
    shadow = cast(Shadow, table.text("shadow", "map", SHADOWS))
    light = kind.from_table(table, shadow=shadow, name=table.text("name", ""))
    light = dataclasses.replace(light, motion=read_motion(table, light.place or (0.0, 0.0, 0.0)))
    builder.add_light(light)
