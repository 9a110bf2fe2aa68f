"""Textures read as images: the same texels, and only where nothing else is asked of them."""

from __future__ import annotations

import numpy as np
import pytest
from gpu.single_pixel import HEAD, draw
from program_of_text import fullscreen_source

from ssdo_gl import resources
from ssdo_gl.gpu import program as program_module
from ssdo_gl.gpu.context import draws_on_cpu
from ssdo_gl.gpu.shader import ShaderError
from ssdo_gl.gpu.shader_source import flatten
from ssdo_gl.gpu.software.image_reads import MOST_IMAGES, with_image_reads
from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.passes.terms import MOST_IRRADIANCES, MOST_RADIANCES


def read(declarations, body):
    text = f"{HEAD}{declarations}\nvoid main()\n{{\n    {body}\n}}\n"
    return with_image_reads(flatten("a.frag", lambda _: text))


def test_what_texels_are_fetched_from_becomes_an_image():
    changed, units = read(
        "uniform sampler2D t_a;  // t_a\nuniform usampler2D t_b;",
        "o_color = texelFetch (t_a, textureSize(t_a, 0) - 1, 0) + texelFetch(t_b, ivec2(0), 0);",
    )
    assert units == {"t_a": 0, "t_b": 1}
    assert "layout(rgba32f, binding = 0) readonly uniform image2D t_a;" in changed.code
    assert "layout(rgba32ui, binding = 1) readonly uniform uimage2D t_b;" in changed.code
    assert "image_texel (t_a, image_size(t_a, 0) - 1, 0) + image_texel(t_b" in changed.code


@pytest.mark.parametrize(
    ("declarations", "body"),
    [
        ("uniform sampler2D t_a;", "o_color = textureLod(t_a, vec2(0.0), 0.0);"),
        ("uniform sampler2D t_a;", "o_color = texelFetch(t_a, ivec2(0), 0); texture(t_a, UV);"),
        ("uniform sampler2D t_a;", "o_color = vec4(1.0);"),
        ("uniform sampler2D t_a, t_b;", "o_color = texelFetch(t_a, ivec2(0), 0);"),
        ("uniform sampler2DArray t_a;", "o_color = texelFetch(t_a, ivec3(0), 0);"),
        ("uniform sampler2D t_a;\nvec4 of(sampler2D a) { return texelFetch(a, ivec2(0), 0); }",
         "o_color = of(t_a);"),
    ],
)  # fmt: skip
def test_what_is_asked_for_more_stays_a_texture(declarations, body):
    changed, units = read(declarations, body)
    assert not units
    assert "image2D" not in changed.code


def test_all_terms_of_the_picture_become_images():
    terms = resources.folder("shaders").joinpath("lib/terms.glsl").read_text(encoding="utf-8")
    defines = {"IRRADIANCE_COUNT": MOST_IRRADIANCES, "RADIANCE_COUNT": MOST_RADIANCES}
    source = flatten("a.frag", lambda _: f"#version 330 core\n{terms}", defines)
    _, units = with_image_reads(source)
    assert len(units) == MOST_IRRADIANCES + MOST_RADIANCES


def test_lines_are_found_where_they_were_written():
    changed, _ = read("uniform sampler2D t_a;", "o_color = texelFetch(t_a, ivec2(0), 0);")
    assert changed.text.count("\n") == len(changed.positions)
    line = changed.code[: changed.code.index("o_color = ")].count("\n") + 1
    assert changed.locate(line) == "a.frag:6"


@pytest.mark.parametrize(
    ("components", "dtype", "values"),
    [
        (1, "f4", [0.1]),
        (2, "f4", [-3.0e38, 1e-30]),
        (4, "f4", [0.1, -2.0, 3e9, 0.0]),
        (4, "f2", [0.5, -2.0, 6e4, 0.0]),
        (1, "nu1", [1.0]),
        (4, "nu1", [0.0, 1.0, 0.2, 0.4]),
        (4, "nu2", [0.0, 1.0, 32767 / 65535, 1 / 65535]),
        (2, "i4", [-5, 1 << 30]),
        (4, "u4", [0, 1, (1 << 32) - 1, 77]),
    ],
)
def test_every_format_reads_as_a_texture_does(gl, shaders, components, dtype, values):
    """Whatever format the shader declares, which is one for all."""
    image = make_texture(gl, (1, 1), components, dtype, [[values]])
    sampler = {"i4": "isampler2D", "u4": "usampler2D"}.get(dtype, "sampler2D")
    # Bits, so that no conversion takes part.
    bits = {"i4": "intBitsToFloat", "u4": "uintBitsToFloat"}.get(dtype, "")
    text = f"{HEAD}uniform {sampler} t_a;\nvoid main() {{ o_color = {bits}(READ); }}\n"
    fetched, looked_up = (
        draw(gl, fullscreen_source(shaders, text.replace("READ", call)), textures={"t_a": image})
        for call in ("texelFetch(t_a, ivec2(0), 0)", "textureLod(t_a, vec2(0.5), 0.0)")
    )
    np.testing.assert_array_equal(fetched.view(np.uint32), looked_up.view(np.uint32))
    wanted = np.array(values, {"i4": np.int32, "u4": np.uint32}.get(dtype, np.float32))
    found = fetched[:components].view(wanted.dtype)
    np.testing.assert_allclose(found, wanted, rtol=1e-3 if dtype == "f2" else 3e-7)


def test_more_textures_than_images_are_all_read(gl, shaders):
    count = MOST_IMAGES + 3
    names = [f"t_{i}" for i in range(count)]
    declared = "".join(f"uniform sampler2D {name};\n" for name in names)
    total = " + ".join(f"texelFetch({name}, ivec2(0), 0)" for name in names)
    text = f"{HEAD}{declared}void main()\n{{\n    o_color = {total};\n}}\n"
    images = {name: make_texture(gl, (1, 1), 1, "f4", [[[2.0**i]]]) for i, name in enumerate(names)}
    found = draw(gl, fullscreen_source(shaders, text), textures=images)
    # Of a float's 24 bits, the upper ones.
    np.testing.assert_allclose(found[0], 2.0**count - 1, rtol=1e-6)


def test_a_texture_that_is_not_given_is_named(gl, shaders):
    text = (
        f"{HEAD}uniform sampler2D t_a;\nvoid main() {{ o_color = texelFetch(t_a, ivec2(0), 0); }}\n"
    )
    with pytest.raises(ShaderError, match="t_a"):
        draw(gl, fullscreen_source(shaders, text))


def test_a_driver_without_images_is_given_textures(gl, shaders, monkeypatch):
    if not draws_on_cpu(gl):
        pytest.skip("textures are read as such here")

    def without(fragment):
        changed, units = with_image_reads(fragment)
        code = changed.code.replace("image_load_store", "no_such_thing")
        return flatten("a.frag", lambda _: code), units

    monkeypatch.setattr(program_module, "with_image_reads", without)
    text = (
        f"{HEAD}uniform sampler2D t_a;\nvoid main() {{ o_color = texelFetch(t_a, ivec2(0), 0); }}\n"
    )
    image = make_texture(gl, (1, 1), 1, "f4", [[[0.5]]])
    program = fullscreen_source(shaders, text, name="<without images>")
    assert draw(gl, program, textures={"t_a": image})[0] == 0.5
