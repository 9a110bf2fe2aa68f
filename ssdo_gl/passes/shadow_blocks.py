"""Min-max hierarchies of shadow maps, by planes: ``shaders/lib/shadow_blocks.glsl``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import moderngl

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.gpu.texture import drawing_into, make_texture
from ssdo_gl.math3d import Region
from ssdo_gl.scene.shadow_frames import ShadowFrame

BLOCK_TEXELS, BLOCK_LEVELS = 8, 7


class ShadowBlocks:
    """Bounds of maps in quads (`quads_of`), made in half the time that drawing the maps takes.

    Parameters
    ----------
    frames : sequence of ShadowFrame or None
        Of all lights.
    size : int
        Texels along a tile of the atlas, a multiple of `BLOCK_TEXELS`.

    Attributes
    ----------
    grid : (int, int)
        Squares of the lowest level.
    """

    def __init__(
        self,
        gl: moderngl.Context,
        shaders: ShaderLibrary,
        quads: moderngl.Texture,
        frames: Sequence[ShadowFrame | None],
        size: int,
    ) -> None:
        self._gl, self._shaders = gl, shaders
        step = BLOCK_TEXELS << (BLOCK_LEVELS - 1)
        columns, rows = (-(-2 * n // step) << (BLOCK_LEVELS - 1) for n in quads.size)
        self.grid = columns, rows
        self.texture = make_texture(gl, (columns + columns // 2, rows), 4, "f4")
        with drawing_into(gl, self.texture) as target:
            target.clear()
            for frame in frames:
                if frame is not None:
                    self._draw_first(target, quads, frame, size)
        corner = 0
        for level, level_size in self._levels():
            # Read and written back, because a texture cannot be drawn to and read from at once.
            made = self._level(level, level_size)
            self.texture.write(made, viewport=(columns, corner, *level_size))
            corner += level_size[1]

    def _levels(self) -> Iterator[tuple[int, tuple[int, int]]]:
        for level in range(1, BLOCK_LEVELS):
            yield level, (self.grid[0] >> level, self.grid[1] >> level)

    def _draw_first(
        self,
        target: moderngl.Framebuffer,
        quads: moderngl.Texture,
        frame: ShadowFrame,
        size: int,
    ) -> None:
        defines = {"IS_FIRST": 1, "IS_PARALLEL": int(frame.is_parallel)}
        sides = frame.face_count * frame.span, frame.span
        region: Region = tuple(n * size // BLOCK_TEXELS for n in (*frame.tile, *sides))  # type: ignore[assignment]
        draw_fullscreen(
            self._gl,
            self._shaders.fullscreen("passes/shadow_blocks.frag", defines),
            target,
            {"u_far_depth": 2.0 * frame.depth} if frame.is_parallel else {},
            {"t_quads": quads},
            region=region,
        )

    def _level(self, level: int, size: tuple[int, int]) -> bytes:
        texture = make_texture(self._gl, size, 4, "f4")
        defines = {"IS_FIRST": 0, "IS_PARALLEL": 0}
        program = self._shaders.fullscreen("passes/shadow_blocks.frag", defines)
        uniforms = {"u_level": level, "u_block_grid": self.grid}
        with drawing_into(self._gl, texture) as target:
            draw_fullscreen(self._gl, program, target, uniforms, {"t_blocks": self.texture})
        made = texture.read()
        texture.release()
        return made
