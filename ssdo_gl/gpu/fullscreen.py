"""Runs a fragment shader once for every pixel of a framebuffer."""

from __future__ import annotations

from collections.abc import Mapping

import moderngl

from ssdo_gl.gpu.shader import Program


def draw_fullscreen(
    gl: moderngl.Context,
    program: Program,
    target: moderngl.Framebuffer,
    uniforms: Mapping[str, object],
    textures: Mapping[str, moderngl.Texture],
) -> None:
    """Draw one triangle over all of `target`: no depth test, no blending, no culling.

    Parameters
    ----------
    gl : moderngl.Context
    program : Program
        From `ShaderLibrary.fullscreen`.
    target : moderngl.Framebuffer
        Its viewport is set to its size.
    uniforms : mapping of str to value
    textures : mapping of sampler name to texture

    Raises
    ------
    ShaderError
        If a name is not declared in the shader, a value does not fit its type, or a
        uniform that the shader uses was never given a value.
    """
    gl.enable_only(moderngl.NOTHING)
    target.use()
    target.viewport = (0, 0, target.width, target.height)
    program.set(uniforms, textures)
    program.check_complete()
    program.empty_vertex_array().render(moderngl.TRIANGLES, vertices=3)
