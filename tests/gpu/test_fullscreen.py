"""The fullscreen triangle: covers every pixel once, with the right coordinates."""

from __future__ import annotations

import numpy as np
import pytest
from gpu.image_texture import texture_from_image
from program_of_text import fullscreen_source

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.shader import ShaderError
from ssdo_gl.gpu.texture import make_framebuffer, make_texture, read_texture

# v_uv is interpolated in float32; the texture is 8 texels at most, so a part in 1e6
# is some ten roundings and far below the half texel that a wrong pixel centre costs.
UV_TOLERANCE = 1e-6


def test_v_uv_is_the_pixel_centre_of_every_pixel(gl, shaders):
    program = fullscreen_source(
        shaders,
        "#version 330 core\nin vec2 v_uv;\nlayout(location = 0) out vec2 o_uv;\n"
        "void main() { o_uv = v_uv; }\n",
    )
    texture = make_texture(gl, (7, 5), 2, "f4")
    target = make_framebuffer(gl, [texture])
    target.clear(-1.0, -1.0)
    draw_fullscreen(gl, program, target, {}, {})
    image = read_texture(texture)
    x, y = np.meshgrid((np.arange(7) + 0.5) / 7, 1.0 - (np.arange(5) + 0.5) / 5)
    np.testing.assert_allclose(image, np.stack([x, y], -1), atol=UV_TOLERANCE)


def test_state_of_an_earlier_draw_does_not_leak(gl, shaders):
    import moderngl

    program = fullscreen_source(
        shaders,
        "#version 330 core\nlayout(location = 0) out vec4 o_color;\n"
        "void main() { o_color = vec4(0.5); }\n",
    )
    texture = make_texture(gl, (4, 4), 4, "f4")
    target = make_framebuffer(gl, [texture], depth=True)
    target.clear(1.0, 1.0, 1.0, 1.0, depth=0.0)  # the depth test would reject everything
    target.viewport = (0, 0, 1, 1)
    gl.enable(moderngl.DEPTH_TEST | moderngl.BLEND | moderngl.CULL_FACE)
    draw_fullscreen(gl, program, target, {}, {})
    assert np.all(read_texture(texture) == 0.5)


def test_the_last_attachment_can_be_left_as_it_is(gl, shaders):
    program = fullscreen_source(
        shaders,
        "#version 330 core\nlayout(location = 0) out vec4 o_color;\n"
        "void main() { o_color = vec4(0.5); }\n",
    )
    textures = [make_texture(gl, (4, 4), 4, "f4") for _ in range(2)]
    target = make_framebuffer(gl, textures)
    target.clear(1.0, 2.0, 3.0, 4.0)
    draw_fullscreen(gl, program, target, {}, {}, keeps_last=True)
    assert np.all(read_texture(textures[0]) == 0.5)
    assert np.all(read_texture(textures[1]) == [1.0, 2.0, 3.0, 4.0])
    # The next one to draw there may change all again.
    target.clear(5.0, 5.0, 5.0, 5.0)
    assert np.all(read_texture(textures[1]) == 5.0)


def test_a_uniform_that_was_never_set_is_refused(gl, shaders):
    program = fullscreen_source(
        shaders,
        "#version 330 core\nuniform float u_gain;\nuniform sampler2D t_image;\n"
        "layout(location = 0) out vec4 o_color;\n"
        "void main() { o_color = u_gain * texelFetch(t_image, ivec2(0), 0); }\n",
    )
    target = make_framebuffer(gl, [make_texture(gl, (1, 1), 4, "f4")])
    image = texture_from_image(gl, np.ones((1, 1, 4)))
    with pytest.raises(ShaderError, match="never set: t_image, u_gain"):
        draw_fullscreen(gl, program, target, {}, {})
    draw_fullscreen(gl, program, target, {"u_gain": 2.0}, {"t_image": image})
