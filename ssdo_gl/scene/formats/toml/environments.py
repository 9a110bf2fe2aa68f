"""The [environment] table."""

from __future__ import annotations

from pathlib import Path

from ssdo_gl.scene.builder import SceneBuilder
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

_KEYS: dict[str, tuple[str, ...]] = {
    "constant": ("radiance",),
    "gradient": ("zenith", "horizon", "ground"),
    "map": ("path", "rotation_y", "scale"),
    "sky": ("hour", "latitude", "day", "turbidity", "north"),
}


def read_environment(
    table: Table | None, file: Path | None, builder: SceneBuilder
) -> Environment | None:
    """Return the environment that the table describes, or None."""
    if table is None:
        return None
    kind = table.text("kind", choices=tuple(_KEYS))
    table.allow("kind", *_KEYS[kind])
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
