"""Fetches of texels, which software draws as lookups at their centres."""

from __future__ import annotations

import numpy as np
import pytest
from program_of_text import fullscreen_source

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.texture import make_framebuffer, make_texture, read_texture

# Mirrored, so that a shift by a part of a texel does not go unnoticed either way.
SOURCE = """#version 330 core
uniform sampler2D t_image;
layout(location = 0) out vec4 o_color;
void main()
{
    ivec2 last = textureSize(t_image, 0) - 1;
    o_color = texelFetch(t_image, last - ivec2(gl_FragCoord.xy), 0);
}
"""


@pytest.mark.parametrize("size", [(1, 1), (3, 7), (640, 360), (1001, 13), (16384, 3), (3, 16383)])
@pytest.mark.parametrize(("components", "dtype"), [(1, "f4"), (4, "f4"), (4, "nu2"), (4, "nu1")])
def test_every_fetch_finds_its_texel(gl, shaders, size, components, dtype):
    width, height = size
    number = np.arange(width * height * components) % 251
    values = number.reshape(height, width, components) / 255.0
    image = make_texture(gl, size, components, dtype, values)
    target = make_texture(gl, size, 4, "f4")
    program = fullscreen_source(shaders, SOURCE)
    draw_fullscreen(gl, program, make_framebuffer(gl, [target]), {}, {"t_image": image})
    found = read_texture(target)[:, :, :components]
    # Integers become floats within a rounding of how the host does it; neighbours differ by 4e-3.
    np.testing.assert_allclose(found, read_texture(image)[::-1, ::-1], rtol=3e-7)
