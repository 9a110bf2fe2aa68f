"""Full-screen shaders as compute shaders: the same pixels, or a rasterizer's."""

from __future__ import annotations

import dataclasses

import moderngl
import numpy as np
import pytest
from program_of_text import fullscreen_source

from ssdo_gl.gpu.clear import clear
from ssdo_gl.gpu.compute import compute_source, computes_faster
from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.geometry import triangle_rasterizer
from ssdo_gl.gpu.shader import FULLSCREEN, ShaderError, ShaderLibrary
from ssdo_gl.gpu.shader_source import flatten
from ssdo_gl.gpu.texture import make_framebuffer, make_texture, read_texture
from ssdo_gl.options.resolve import settings_for
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene

SIZE = (37, 21)  # no whole number of groups, nor of quads
# By hash, so that neighbours differ in all bits; in range of every format.
SHADER = """#version 330 core
in vec2 v_uv;
uniform vec4 u_factor;
layout(location = 0) out vec4 o_value;
layout(location = 1) out vec2 o_place;
void main()
{
    vec2 p = gl_FragCoord.xy;
    if (p.x < 3.0) {
        o_value = vec4(0.25);
        o_place = vec2(1.0, 0.0);
        return;
    }
    o_value = u_factor * fract(sin(vec4(p.x, p.y, p.x + 7.0 * p.y, 1.0)) * 437.5);
    o_place = v_uv;
}
"""
DERIVATIVES = SHADER.replace("o_place = v_uv", "o_place = dFdx(v_uv)")
SCREEN_ONLY = [
    "if (gl_FragCoord.x < 2.0) discard;",
    "gl_FragDepth = 0.5;",
    "o_value = texture(t_image, gl_FragCoord.xy);",
    "o_value = vec4(gl_FrontFacing);",
]


def drawn(gl, library, text, dtype="f4", *, region=None, times=1, factor=1.0):
    textures = [make_texture(gl, SIZE, n, dtype, np.full((*SIZE[::-1], n), 0.125)) for n in (4, 2)]
    target = make_framebuffer(gl, textures)
    program = fullscreen_source(library, text)
    for number in range(times):
        uniforms = {"u_factor": (factor,) * 4}
        draw_fullscreen(gl, program, target, uniforms, {}, region=region, adds=number > 0)
    images = [read_texture(texture) for texture in textures]
    for item in (target, *textures):
        item.release()
    return program, images


@pytest.mark.parametrize("dtype", ["f4", "f2", "nu1", "nu2"])
@pytest.mark.parametrize("region", [None, (5, 3, 17, 11), (36, 20, 1, 1)])
def test_pixels_are_those_of_a_rasterizer(gl, computing, dtype, region):
    program, found = drawn(gl, computing, SHADER, dtype, region=region)
    assert program.compute is not None
    _, wanted = drawn(gl, ShaderLibrary(gl), SHADER, dtype, region=region)
    np.testing.assert_array_equal(found[0], wanted[0])
    # The coordinate is interpolated there, and divided here.
    np.testing.assert_allclose(found[1], wanted[1], rtol=2e-7, atol=1e-7 if dtype == "f4" else 5e-3)
    if region is not None:
        x, y, width, height = region
        outside = np.ones(SIZE[::-1], bool)
        outside[::-1][y : y + height, x : x + width] = False  # row 0 is the top one
        assert np.ptp(found[0][outside]) == 0.0, "what lies outside of the region was drawn over"


@pytest.mark.parametrize("dtype", ["f4", "f2"])
def test_results_add_up(gl, computing, dtype):
    _, found = drawn(gl, computing, SHADER, dtype, times=3, factor=0.5)
    _, wanted = drawn(gl, ShaderLibrary(gl), SHADER, dtype, times=3, factor=0.5)
    # Sums are rounded to the format twice; how blending rounds halves is the device's affair.
    np.testing.assert_allclose(found[0], wanted[0], rtol=0.0 if dtype == "f4" else 2.0**-9)
    assert found[0].max() > 1.0


@pytest.mark.parametrize("statement", SCREEN_ONLY)
def test_what_needs_a_rasterizer_is_left_to_it(gl, computing, statement):
    text = SHADER.replace("    vec2 p =", f"    {statement}\n    vec2 p =")
    text = text.replace("uniform vec4", "uniform sampler2D t_image;\nuniform vec4")
    assert fullscreen_source(computing, text).compute is None


def test_derivatives_need_an_extension(gl, computing):
    program = fullscreen_source(computing, DERIVATIVES)
    has_extension = "GL_NV_compute_shader_derivatives" in gl.extensions
    assert (program.compute is not None) == has_extension


def test_the_made_source_keeps_files_and_lines():
    source = flatten("x.frag", {"x.frag": SHADER}.__getitem__)
    made = compute_source(source)
    assert made is not None
    wanted = SHADER.split("\n").index("    o_place = v_uv;") + 1
    line = made.text.split("\n").index("    o_place = v_uv;") + 1
    assert made.locate(line) == f"x.frag:{wanted}"


def test_a_faulty_shader_is_reported_as_ever(computing):
    with pytest.raises(ShaderError, match=r"<test>:\d+: .*u_facto\b"):
        fullscreen_source(computing, SHADER.replace("= u_factor", "= u_facto"))


@pytest.mark.parametrize("channels", [(4, 1), (1,)])
def test_a_target_is_cleared_and_can_be_drawn_into(gl, computing, channels):
    textures = [make_texture(gl, SIZE, n, "f4", np.full((*SIZE[::-1], n), 0.5)) for n in channels]
    target = make_framebuffer(gl, textures, depth=True)
    mask = target.color_mask
    target.use()
    clear(gl, computing, target)
    assert all(not read_texture(texture).any() for texture in textures)
    assert target.color_mask == mask
    depth = np.frombuffer(target.read(components=1, attachment=-1, dtype="f4"), np.float32)
    np.testing.assert_array_equal(depth, 1.0)
    # As a pass does, which finds its target bound.
    program = fullscreen_source(ShaderLibrary(gl), SHADER)
    program.set({"u_factor": (1.0,) * 4})
    gl.enable_only(moderngl.NOTHING)
    program.empty_vertex_array().render(moderngl.TRIANGLES, vertices=3)
    assert read_texture(textures[0]).any()


@pytest.mark.parametrize(
    ("name", "method"),
    [("cornell_meso", "gi"), ("coloured_lights", "bounce"), ("corner", "reference-near")],
)
def test_pictures_are_equal(device, computing, name, method, monkeypatch):
    """Of the same G-buffer: triangles are rasterized either way."""
    monkeypatch.setattr(triangle_rasterizer, "MOST_BATCHES", 0)
    scene = load_scene(name)
    fields = {"method": method, "size": (64, 36), "spp": 2}
    images = []
    for library in (computing, ShaderLibrary(device.gl)):
        settings = settings_for(scene.render, fields)
        with Renderer(scene, settings, device=device, shaders=library) as renderer:
            images.append(renderer.render(("display", "beauty", "normal_ws")).images)
    for aov, image in images[0].items():
        np.testing.assert_allclose(image, images[1][aov], rtol=1e-5, atol=1e-6, err_msg=aov)


@pytest.mark.parametrize("name", ["cornell_meso", "stairs"])
def test_pictures_of_computed_triangles_differ_in_ties_only(device, computing, name):
    """Depths differ by rounding, and what they decide where two surfaces meet."""
    scene = load_scene(name)
    # Not the scene's own, in which edges run through the centres of pixels.
    x, y, z = scene.camera.position
    camera = dataclasses.replace(scene.camera, position=(1.003 * x + 0.003, 1.002 * y, z))
    settings = settings_for(scene.render, {"method": "bounce", "size": (160, 90)})
    images = []
    for library in (computing, ShaderLibrary(device.gl)):
        with Renderer(scene, settings, device=device, shaders=library) as renderer:
            images.append(renderer.render(("beauty", "depth"), camera=camera).images)
    depths = [np.nan_to_num(each["depth"], posinf=0.0) for each in images]
    assert (depths[0] != depths[1]).any()  # two ways, indeed
    assert np.mean(np.abs(depths[0] - depths[1]) > 1e-4 * depths[1]) < 5e-4
    gap = np.abs(images[0]["beauty"] - images[1]["beauty"]).max(-1)
    assert np.mean(gap > 0.01 * images[1]["beauty"].mean()) < 0.003


def test_the_two_ways_can_be_timed(gl):
    """A software renderer is as fast either way; only that it runs, and leaves no error."""
    assert computes_faster(gl) in (True, False)


def test_a_program_for_the_screen_is_never_computed(computing):
    assert computing.program(FULLSCREEN, "passes/copy.frag").compute is None
