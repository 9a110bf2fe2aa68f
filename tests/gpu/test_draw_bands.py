"""Draws in bands: the same bytes, and a chance to answer in between."""

from __future__ import annotations

import numpy as np
import pytest
from program_of_text import fullscreen_source

from ssdo_gl.gpu.fullscreen import FIRST_PIXELS, SLICE_MS, DrawBands, draw_fullscreen
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.gpu.texture import make_framebuffer, make_texture
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings

# Large enough for several bands of programs that nobody knows.
SIZE = (256, 144)
SLOW = (
    "#version 330 core\nin vec2 v_uv;\nlayout(location = 0) out vec4 o_color;\n"
    "uniform float u_turns;\n"
    "void main() { float x = v_uv.x;\n"
    "for (float i = 0.0; i < u_turns; i += 1.0) x = fract(sin(x * 12.9) * 437.5);\n"
    "o_color = vec4(x); }\n"
)


@pytest.mark.parametrize("method", ["bounce", "reference-gi"])
def test_a_frame_in_bands_is_the_same_frame(gl, device, method: str) -> None:
    scene = load_scene("cornell_meso")
    settings = Settings(size=SIZE, method=method, samples=8, steps=4, spp=2, antialias=1)
    with Renderer(scene, settings, device=device) as renderer:
        at_once = renderer.draw(["beauty"], camera=scene.camera)
        expected = at_once.planes["beauty"].read()
        renderer.forget()
        pauses = []
        sliced = renderer.draw(
            ["beauty"], camera=scene.camera, progress=lambda *_: pauses.append(clobber(gl))
        )
        assert len(pauses) > 2 * SIZE[0] * SIZE[1] // FIRST_PIXELS
        assert np.array_equal(sliced.planes["beauty"].read(), expected)
        assert expected.std() > 0.1


def clobber(gl) -> None:
    """Leave all state as another drawing might."""
    import moderngl

    target = make_framebuffer(gl, [make_texture(gl, (3, 3), 4, "nu1")])
    target.use()
    gl.viewport = (0, 0, 3, 3)
    gl.enable_only(moderngl.BLEND | moderngl.CULL_FACE)
    gl.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA
    for unit in range(16):
        make_texture(gl, (1, 1), 4, "f4").use(unit)


def test_bands_shrink_until_they_fit(gl) -> None:
    # By a rasterizer, whose scissor tells what was drawn.
    program = fullscreen_source(ShaderLibrary(gl), SLOW)
    target = make_framebuffer(gl, [make_texture(gl, SIZE, 4, "f4")])
    bands = DrawBands(gl)
    heights = []

    def draw() -> None:
        with bands.pausing(lambda: heights.append(target.scissor[3])):
            draw_fullscreen(gl, program, target, {"u_turns": 40000.0}, {})

    draw()
    assert sum(heights) == SIZE[1]
    assert heights[0] == FIRST_PIXELS // SIZE[0]
    assert heights[1] < heights[0], f"{heights} rows were not too slow for {SLICE_MS} ms"
    assert all(height % 2 == 0 for height in heights)
    # Nobody asks for bands any more.
    count = len(heights)
    draw_fullscreen(gl, program, target, {"u_turns": 1.0}, {})
    assert len(heights) == count
    assert gl.extra is None


def test_a_frame_that_is_given_up_leaves_no_bands_behind(gl, shaders) -> None:
    program = fullscreen_source(shaders, SLOW)
    target = make_framebuffer(gl, [make_texture(gl, SIZE, 4, "f4")])

    def stop() -> None:
        raise InterruptedError

    with pytest.raises(InterruptedError), DrawBands(gl).pausing(stop):
        draw_fullscreen(gl, program, target, {"u_turns": 1.0}, {})
    assert gl.extra is None
