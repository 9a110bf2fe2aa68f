"""Draws one triangle; run as a script, with a backend of its own process.

Usage: python triangle.py BACKEND OUT.npy
"""

from __future__ import annotations

import sys

import moderngl
import numpy as np
from numpy.typing import NDArray

from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.gpu.texture import make_framebuffer, make_texture, read_texture

SIZE = (16, 12)
# Exact in binary, so every driver must write the same bits.
COLOR = (0.25, 0.5, 1.0, 1.0)
# No edge passes through a pixel centre: which pixels are covered is no matter of rounding.
CORNERS_NDC = ((-0.83, -0.71), (0.91, -0.47), (0.13, 0.87))


def draw_triangle(device: Device) -> NDArray[np.float32]:
    """Return the picture of the triangle, (12, 16, 4), row 0 at the top."""
    gl = device.gl
    program = gl.program(
        vertex_shader="#version 330 core\nin vec2 a_position;\n"
        "void main() { gl_Position = vec4(a_position, 0.0, 1.0); }",
        fragment_shader="#version 330 core\nuniform vec4 u_color;\n"
        "layout(location = 0) out vec4 o_color;\nvoid main() { o_color = u_color; }",
    )
    program["u_color"] = COLOR
    texture = make_texture(gl, SIZE, 4, "f4")
    target = make_framebuffer(gl, [texture])
    corners = gl.buffer(np.array(CORNERS_NDC, np.float32).tobytes())
    gl.enable_only(moderngl.NOTHING)
    target.use()
    target.clear()
    gl.vertex_array(program, [(corners, "2f", "a_position")]).render()
    return read_texture(texture)


if __name__ == "__main__":
    device = create_context(sys.argv[1])
    assert device.backend == sys.argv[1]
    np.save(sys.argv[2], draw_triangle(device))
    device.release()
