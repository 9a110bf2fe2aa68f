"""Runs a shader once for every pixel of a framebuffer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import moderngl

from ssdo_gl.gpu.clear import last_kept
from ssdo_gl.gpu.draw_bands import bands
from ssdo_gl.gpu.program import Program
from ssdo_gl.math3d import Region


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
