"""Textures keep what is put in; read-back and upload agree on which row is the top."""

from __future__ import annotations

import moderngl
import numpy as np
import pytest
from gpu.image_texture import texture_from_image
from program_of_text import fullscreen_source

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.texture import FrameSizeError, make_framebuffer, make_texture, read_texture

# Rounding to the nearest of 2^n - 1 steps is off by half a step at most; the division
# back to float32 adds one rounding.
STEP_TOLERANCE = {"nu1": 0.5 / 255 + 1e-7, "nu2": 0.5 / 65535 + 1e-7, "f2": 2.0**-11, "f4": 0.0}
FETCH = (
    "#version 330 core\nuniform sampler2D t_image;\nuniform ivec2 u_texel;\n"
    "layout(location = 0) out vec4 o_color;\n"
    "void main() { o_color = texelFetch(t_image, u_texel, 0); }\n"
)


def gradient(components, size=(5, 3)):
    """An image with a different value in every channel of every texel, [0, 1)."""
    count = size[0] * size[1] * components
    return (np.arange(count, dtype=np.float32) / count).reshape(size[1], size[0], components)


@pytest.mark.parametrize("components", [1, 2, 3, 4])
@pytest.mark.parametrize("dtype", STEP_TOLERANCE)
def test_image_survives_upload_and_read_back(gl, components, dtype):
    # An odd width: rows of 8-bit RGB would be padded if alignment were OpenGL's 4.
    image = gradient(components)
    result = read_texture(texture_from_image(gl, image, dtype))
    assert result.dtype == np.float32 and result.shape == image.shape
    np.testing.assert_allclose(result, image, rtol=0, atol=STEP_TOLERANCE[dtype])


def test_row_0_of_an_image_is_the_top_and_of_texture_data_the_bottom(gl, shaders):
    program = fullscreen_source(shaders, FETCH)
    image = gradient(4)
    output = make_texture(gl, (1, 1), 4, "f4")
    target = make_framebuffer(gl, [output])
    for texture, bottom_row in (
        (texture_from_image(gl, image), image[-1]),
        (make_texture(gl, (5, 3), 4, "f4", image), image[0]),
    ):
        draw_fullscreen(gl, program, target, {"u_texel": (1, 0)}, {"t_image": texture})
        np.testing.assert_array_equal(read_texture(output)[0, 0], bottom_row[1])


def test_shader_sees_normalised_integers_as_written(gl, shaders):
    program = fullscreen_source(shaders, FETCH)
    output = make_texture(gl, (1, 1), 4, "f4")
    texture = make_texture(gl, (1, 1), 4, "nu2", [0.0, 0.25, 1.0, 2.0])
    draw_fullscreen(
        gl, program, make_framebuffer(gl, [output]), {"u_texel": (0, 0)}, {"t_image": texture}
    )
    expected = np.array([0, round(0.25 * 65535) / 65535, 1, 1])  # clamped, not wrapped around
    # One float32 rounding in the driver's conversion.
    np.testing.assert_allclose(read_texture(output)[0, 0], expected, rtol=0, atol=1e-7)


def test_special_floats_survive(gl):
    image = np.array([[np.inf, -np.inf, np.nan, np.float32(3.4e38), -0.0, 1e-30]], np.float32)
    np.testing.assert_array_equal(read_texture(texture_from_image(gl, image))[..., 0], image)


def test_texture_is_read_texel_by_texel_and_clamped(gl, shaders):
    program = fullscreen_source(
        shaders,
        "#version 330 core\nuniform sampler2D t_image;\nuniform vec2 u_uv;\n"
        "layout(location = 0) out vec4 o_color;\n"
        "void main() { o_color = texture(t_image, u_uv); }\n",
    )
    image = np.array([[1.0, 2.0, 3.0]])
    texture = texture_from_image(gl, image)
    output = make_texture(gl, (1, 1), 4, "f4")
    target = make_framebuffer(gl, [output])
    for u, expected in ((0.3, 1), (0.4, 2), (0.6, 2), (-5.0, 1), (7.0, 3)):
        draw_fullscreen(gl, program, target, {"u_uv": (u, 0.5)}, {"t_image": texture})
        assert read_texture(output)[0, 0, 0] == expected


def test_framebuffer_draws_into_its_textures_in_order(gl, shaders):
    program = fullscreen_source(
        shaders,
        "#version 330 core\n"
        "layout(location = 0) out vec4 o_a;\nlayout(location = 1) out float o_b;\n"
        "void main() { o_a = vec4(1.0, 2.0, 3.0, 4.0); o_b = 5.0; }\n",
    )
    a, b = make_texture(gl, (3, 2), 4, "f4"), make_texture(gl, (3, 2), 1, "f4")
    framebuffer = make_framebuffer(gl, [a, b], depth=True)
    assert framebuffer.depth_attachment is not None
    draw_fullscreen(gl, program, framebuffer, {}, {})
    assert np.all(read_texture(a) == [1, 2, 3, 4]) and np.all(read_texture(b) == 5)
    assert make_framebuffer(gl, [a]).depth_attachment is None


def test_framebuffer_can_be_made_after_the_bound_one_was_released(gl):
    texture = make_texture(gl, (2, 2), 4, "f4")
    first = make_framebuffer(gl, [texture])
    first.use()
    first.release()
    second = make_framebuffer(gl, [texture])
    assert gl.error == "GL_NO_ERROR"
    second.clear(1.0, 2.0, 3.0, 4.0)
    assert np.all(read_texture(texture) == [1, 2, 3, 4])


class NoMemory:
    """A context that has no memory for what is drawn into, or some other fault."""

    fbo = None

    def __init__(self, error: str) -> None:
        self.error, self.info = error, {"GL_RENDERER": "a small device"}

    def framebuffer(self, *_textures):
        raise moderngl.Error("the framebuffer is not complete (UNSUPPORTED)")


def test_memory_that_a_device_lacks_is_told_from_faults_of_the_program(gl):
    """It was a traceback wherever a pass makes textures of its own."""
    texture = make_texture(gl, (4, 2), 1, "f4")
    with pytest.raises(FrameSizeError, match=r"a small device makes no more images of 4x2"):
        make_framebuffer(NoMemory("GL_OUT_OF_MEMORY"), [texture])
    with pytest.raises(moderngl.Error, match="UNSUPPORTED"):
        make_framebuffer(NoMemory("GL_NO_ERROR"), [texture])
