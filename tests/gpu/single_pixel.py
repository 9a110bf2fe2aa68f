"""Draws a single pixel by a shader of a test."""

from __future__ import annotations

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.texture import make_framebuffer, make_texture, read_texture

HEAD = "#version 330 core\nlayout(location = 0) out vec4 o_color;\n"


def draw(gl, program, uniforms=None, textures=None):
    """The colour that `program` writes to a single pixel."""
    texture = make_texture(gl, (1, 1), 4, "f4")
    draw_fullscreen(gl, program, make_framebuffer(gl, [texture]), uniforms or {}, textures or {})
    return read_texture(texture)[0, 0]
