"""The [[light]] tables."""

from __future__ import annotations

import dataclasses
from typing import cast, get_args

from ssdo_gl.scene.builder import SceneBuilder
from ssdo_gl.scene.files import Table
from ssdo_gl.scene.formats.toml.motions import MOTION_TABLE, read_motion
from ssdo_gl.scene.lights import KINDS, Shadow

SHADOWS: tuple[str, ...] = get_args(Shadow)
_COMMON = ("kind", "name", "shadow", MOTION_TABLE)


def read_light(table: Table, builder: SceneBuilder) -> None:
    """Add the light of a table."""
    kind = KINDS[table.text("kind", choices=tuple(KINDS))]
    table.allow(*_COMMON, *kind.keys())
    shadow = cast(Shadow, table.text("shadow", "map", SHADOWS))
    light = kind.from_table(table, shadow=shadow, name=table.text("name", ""))
    light = dataclasses.replace(light, motion=read_motion(table, light.place or (0.0, 0.0, 0.0)))
    builder.add_light(light)
