"""Classifies tiles of pixels as lit, dark or mixed: only mixed ones read a light's shadow map."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple
from weakref import WeakKeyDictionary

import moderngl
import numpy as np

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.texture import make_framebuffer, make_texture
from ssdo_gl.graph.render_pass import PassContext
from ssdo_gl.passes.light_draws import MIXED, TILE_PIXELS, LightDraw
from ssdo_gl.passes.shadow_blocks import BLOCK_TEXELS, ShadowBlocks
from ssdo_gl.scene.shadow_frames import ShadowFrame

# To tell so few apart takes as long as they do.
LEAST_TILES = 128
# The share of tiles that must be told for it to pay, of sharp lights and of those with a size: in
# `courtyard` by a lamp a fifth is, and direct light would take 1.15 of its time.
LEAST_TOLD = (0.3, 0.1)
# The share is asked for again after so many draws.
TURNS = 16


class MapsInQuads(NamedTuple):
    """The maps of all lights, from `quads_of`; frames; texels along a tile; who reads them."""

    quads: moderngl.Texture
    frames: Sequence[ShadowFrame | None]
    tile_texels: int
    reader: object


class _Telling:
    """Tiles of a view, what they are told by, and for which lights it pays."""

    def __init__(self, gl: moderngl.Context, blocks: ShadowBlocks, size: tuple[int, int]) -> None:
        self.blocks = blocks
        self.tiles = make_texture(gl, size, 1, "f4")
        self.target = make_framebuffer(gl, [self.tiles])
        self.turns: dict[int, int] = {}
        self.pays: dict[int, bool] = {}

    def tell(self, context: PassContext, maps: MapsInQuads, light: LightDraw) -> None:
        """Find out what tiles see of a light."""
        switches = ("LIGHT_FORM", "IS_SOFT", "HAS_LIFT")
        defines = {name: light.defines[name] for name in switches}
        inputs = ("t_z_vs", "t_normals_vs", *(("t_lift_vs",) if defines["HAS_LIFT"] else ()))
        shader = "passes/light_tiles.frag"
        draw_fullscreen(
            context.gl,
            context.shaders.fullscreen(shader, {**defines, "TILE_PIXELS": TILE_PIXELS}),
            self.target,
            {
                **context.frame.view.uniforms(),
                "u_light": light.uniforms["u_light"],
                "u_shadow_tile_texels": maps.tile_texels,
                "u_block_grid": self.blocks.grid,
            },
            {
                **{name: light.textures[name] for name in inputs},
                "t_shadow_blocks": self.blocks.texture,
            },
        )


class _KeptWithMaps:
    """What tells tiles by the maps that it is kept with: views of a scene share them."""

    def __init__(self, context: PassContext, maps: MapsInQuads) -> None:
        given = maps.quads, maps.frames, maps.tile_texels
        self.blocks = ShadowBlocks(context.gl, context.shaders, *given)
        self._tellings: WeakKeyDictionary[object, _Telling] = WeakKeyDictionary()

    def of(self, reader: object, gl: moderngl.Context, size: tuple[int, int]) -> _Telling:
        """Return what tells so many columns and rows of tiles of a reader's view."""
        telling = self._tellings.get(reader)
        if telling is None or telling.tiles.size != size:
            telling = self._tellings[reader] = _Telling(gl, self.blocks, size)
        return telling


def light_tiles(
    context: PassContext, maps: MapsInQuads, number: int, light: LightDraw
) -> moderngl.Texture | None:
    """Return which tiles a light leaves dark, open or mixed; None: that would not pay.

    What is drawn by them is bit for bit what pixels find.

    Parameters
    ----------
    number : int
        Of the light in the scene.
    """
    assert context.target is not None
    width, height = context.target.size
    columns, rows = -(-width // TILE_PIXELS), -(-height // TILE_PIXELS)
    is_apart = maps.tile_texels % BLOCK_TEXELS == 0
    if maps.frames[number] is None or columns * rows < LEAST_TILES or not is_apart:
        return None
    kept = maps.quads.extra = maps.quads.extra or _KeptWithMaps(context, maps)
    telling = kept.of(maps.reader, context.gl, (columns, rows))
    turn = telling.turns.get(number, 0)
    telling.turns[number] = turn + 1
    if turn % TURNS and not telling.pays[number]:
        return None
    telling.tell(context, maps, light)
    if turn % TURNS == 0:
        told = np.frombuffer(telling.tiles.read(), np.float32) != MIXED
        telling.pays[number] = bool(told.mean() >= LEAST_TOLD[light.defines["IS_SOFT"]])
    return telling.tiles if telling.pays[number] else None
