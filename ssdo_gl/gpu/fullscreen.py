"""Runs a shader once for every pixel of a framebuffer, at once or in bands with pauses between."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import moderngl

from ssdo_gl.gpu.clear import last_kept
from ssdo_gl.gpu.program import Program
from ssdo_gl.math3d import Region

# With a picture in motion after it, input is still answered within two frames of 60 Hz.
SLICE_MS = 8.0
# The first band of a program whose time nobody knows, in pixels.
FIRST_PIXELS = 16_384
# A band has at most this many times the rows of the one before: cost differs across a picture.
LARGEST_GROWTH = 2.0


class DrawBands:
    """How long programs take per pixel, as far as it was seen."""

    def __init__(self, gl: moderngl.Context) -> None:
        self._gl = gl
        self._pause: Callable[[], None] | None = None
        self._pixels: WeakKeyDictionary[Program, float] = WeakKeyDictionary()

    @contextmanager
    def pausing(self, pause: Callable[[], None]) -> Iterator[None]:
        """Cut all draws of the context into bands and call `pause` after each.

        It may draw other things, and raise to give the frame up.
        """
        self._pause = pause
        self._gl.extra = self
        try:
            yield
        finally:
            self._gl.extra = self._pause = None

    def cut(self, program: Program, region: Region) -> Iterator[Region]:
        """Yield bands of `region`, bottom up; the caller draws each with `program`."""
        x, y, width, height = region
        done = 0
        while done < height:
            pixels = self._pixels.get(program, FIRST_PIXELS)
            # Quads of 2x2 pixels are shaded together, for their derivatives.
            rows = min(max(2, int(pixels / width) // 2 * 2), height - done)
            start = time.perf_counter()
            yield x, y + done, width, rows
            # The work of a software renderer is done while one waits for it.
            self._gl.finish()
            milliseconds = (time.perf_counter() - start) * 1e3
            fitting = width * rows * SLICE_MS / max(milliseconds, 1e-3)
            self._pixels[program] = min(fitting, LARGEST_GROWTH * max(pixels, width * rows))
            done += rows
            if self._pause is not None:
                self._pause()


def bands(gl: moderngl.Context, program: Program, region: Region) -> Iterator[Region]:
    """Yield what to draw of `region` at a time: all of it, unless somebody asked for bands."""
    known: DrawBands | None = gl.extra
    if known is None:
        yield region
    else:
        yield from known.cut(program, region)


class Points(NamedTuple):
    """Points of which a vertex shader makes tiles, in place of one triangle.

    Attributes
    ----------
    reach : (int, int)
        Width and height of the viewport in pixels, in which the target lies at the lower left.
    """

    number: int
    reach: tuple[int, int]


def draw_fullscreen(
    gl: moderngl.Context,
    program: Program,
    target: moderngl.Framebuffer,
    uniforms: Mapping[str, object],
    textures: Mapping[str, moderngl.Texture],
    *,
    region: Region | None = None,
    adds: bool = False,
    keeps_last: bool = False,
    points: Points | None = None,
) -> None:
    """Shade every pixel of `target`, or of `points`: one triangle, or groups of a compute shader.

    Parameters
    ----------
    program : Program
        From `ShaderLibrary.fullscreen`.
    target : moderngl.Framebuffer
        Its viewport is set to its size.
    textures : mapping of sampler name to texture
    region : (int, int, int, int) or None
        Draw there only: x, y, width and height in pixels, from the bottom left.
    adds : bool
        Add to what is there, instead of replacing it.
    keeps_last : bool
        Leave the last attachment as it is: the shader does not write it.

    Raises
    ------
    ShaderError
        If a name is not declared in the shader, a value does not fit its type, a uniform
        that the shader uses was never given a value, or a sampler is not given one now.
    """
    whole = (0, 0, *target.size)
    if keeps_last:
        with last_kept(target):
            more: dict[str, Any] = {"region": region, "adds": adds, "points": points}
            draw_fullscreen(gl, program, target, uniforms, textures, **more)
        return
    parts = (region or whole,) if gl.extra is None else bands(gl, program, region or whole)
    for band in parts:
        if program.compute is not None:
            program.set(uniforms, textures)
            program.check_complete(textures)
            program.compute.run(gl, _textures(target), band, adds=adds)
            continue
        if points is not None:
            _draw_points(gl, program, target, uniforms, textures, band, adds, points)
            continue
        # All state, for each: between two bands other things may be drawn.
        gl.enable_only(moderngl.BLEND if adds else moderngl.NOTHING)
        if adds:
            gl.blend_func = moderngl.ONE, moderngl.ONE
        # What is asked costs a tenth of what is set.
        if target.viewport != whole:
            target.viewport = whole
        if target.scissor != band:
            target.scissor = band
        if gl.fbo is not target:
            target.use()
        program.set(uniforms, textures)
        program.check_complete(textures)
        program.empty_vertex_array().render(moderngl.TRIANGLES, vertices=3)
    if region is not None or gl.extra is not None:
        target.scissor = whole
    if adds or program.compute is not None:
        gl.enable_only(moderngl.NOTHING)


def _draw_points(
    gl: moderngl.Context,
    program: Program,
    target: moderngl.Framebuffer,
    uniforms: Mapping[str, object],
    textures: Mapping[str, moderngl.Texture],
    band: Region,
    adds: bool,
    points: Points,
) -> None:
    size = moderngl.PROGRAM_POINT_SIZE
    gl.enable_only(size | moderngl.BLEND if adds else size)
    gl.blend_func = moderngl.ONE, moderngl.ONE
    target.viewport = (0, 0, *points.reach)
    target.scissor = band
    target.use()
    program.set(uniforms, textures)
    program.check_complete(textures)
    program.empty_vertex_array().render(moderngl.POINTS, vertices=points.number)
    target.viewport = (0, 0, *target.size)
    target.scissor = (0, 0, *target.size)
    gl.enable_only(moderngl.NOTHING)


def _textures(target: moderngl.Framebuffer) -> Sequence[moderngl.Texture]:
    # Any: the stubs leave open whether they are renderbuffers.
    attachments: Any = target.color_attachments
    return tuple(attachments)
