"""Draws the light of one lamp, over the whole frame or tile by tile."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import moderngl

from ssdo_gl.gpu.fullscreen import Points, draw_fullscreen
from ssdo_gl.graph.render_pass import PassContext
from ssdo_gl.math3d import Region

# Along the sides of a tile. With 8 more is told and telling takes longer: the same time.
TILE_PIXELS = 16
# What ``passes/light_tiles.frag`` says of a tile.
DARK, OPEN, MIXED = range(3)


class Edge(NamedTuple):
    """A file of ``shadow_edges``, and what it needs."""

    name: str
    defines: Mapping[str, int] = {}
    uniforms: Mapping[str, object] = {}
    textures: Mapping[str, moderngl.Texture] = {}


FILTERED = Edge("filtered")


class LightDraw(NamedTuple):
    """A light with all that ``effects/direct.frag`` reads of it, and where it goes."""

    edge: Edge
    defines: Mapping[str, int]
    uniforms: Mapping[str, object]
    textures: Mapping[str, moderngl.Texture]
    region: Region | None
    adds: bool
    keeps_last: bool

    @property
    def is_told_by_map(self) -> bool:
        """Whether a map alone says where nothing and where all of it arrives."""
        is_traced = self.defines["IS_SOFT"] and self.edge.name != FILTERED.name
        return bool(self.defines["CASTS_SHADOW"]) and not is_traced


def draw_light(context: PassContext, light: LightDraw) -> None:
    """Shade all pixels alike."""
    _draw(context, light, MIXED, None)


def draw_tiles(context: PassContext, light: LightDraw, tiles: moderngl.Texture) -> None:
    """Shade the pixels of tiles as `light_tiles` tells them, one kind after the other."""
    for kind in (OPEN, MIXED) if light.adds else (DARK, OPEN, MIXED):
        _draw(context, light, kind, tiles)


def _draw(
    context: PassContext, light: LightDraw, kind: int, tiles: moderngl.Texture | None
) -> None:
    fragment, edge = "effects/direct.frag", light.edge if kind == MIXED else FILTERED
    choices = {"shadow_edge": f"shadow_edges/{edge.name}.glsl"}
    defines = {**edge.defines, **light.defines, "IS_OPEN": int(kind == OPEN)}
    uniforms = {**light.uniforms, **edge.uniforms}
    textures = {**light.textures, **edge.textures}
    if kind == OPEN:
        # No pixel of an open tile is lifted.
        defines["HAS_LIFT"] = 0
    elif kind == DARK:
        fragment, choices, defines, uniforms, textures = "passes/clear.frag", {}, {}, {}, {}
    points = None
    if tiles is None:
        program = context.shaders.fullscreen(fragment, defines, choices)
    else:
        columns, rows = tiles.size
        points = Points(columns * rows, ((columns + 1) * TILE_PIXELS, (rows + 1) * TILE_PIXELS))
        defines["TILE_PIXELS"] = TILE_PIXELS
        program = context.shaders.program("passes/light_tiles.vert", fragment, defines, choices)
        reach = tuple(float(n) for n in points.reach)
        uniforms.update(u_kind=float(kind), u_viewport_px=reach)
        textures["t_light_tiles"] = tiles
    assert context.target is not None
    draw_fullscreen(
        context.gl,
        program,
        context.target,
        uniforms,
        textures,
        region=light.region,
        adds=light.adds,
        keeps_last=light.keeps_last,
        points=points,
    )
