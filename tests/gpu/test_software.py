"""What software draws otherwise, uniforms and reads of textures: values and lines the same."""

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
from ssdo_gl.gpu.software import MOST_IMAGES, MOST_NUMBERS, with_flat_uniforms, with_image_reads
from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.passes.terms import MOST_IRRADIANCES, MOST_RADIANCES

VERTEX = "#version 330 core\nvoid main()\n{\n    gl_Position = vec4(0.0);\n}\n"


def stage(text, name="a.frag"):
    return flatten(name, lambda _: text)


def flat(declarations, body, vertex=VERTEX):
    fragment = stage(f"{HEAD}{declarations}\nvoid main()\n{{\n    {body}\n}}\n")
    return with_flat_uniforms(stage(vertex, "a.vert"), fragment)


def test_the_vertex_shader_reads_what_the_fragment_takes():
    vertex, fragment = flat(
        "uniform vec3 u_a;  // u_a\nuniform int u_b;", "o_color.rgb = u_a * u_b;"
    )
    assert "uniform vec3 u_a; uniform int u_b; flat out vec3 flat_u_a;" in vertex.code
    assert "{ flat_u_a = u_a; flat_u_b = u_b;" in vertex.code
    assert "flat in vec3 flat_u_a;" in fragment.code
    assert "o_color.rgb = flat_u_a * flat_u_b;" in fragment.code
    assert "uniform" not in fragment.code


def test_lines_stay_where_they_are():
    stages = flat("uniform float u_a;", "o_color = vec4(u_a);")
    assert [s.text.count("\n") for s in stages] == [len(s.positions) for s in stages]
    line = stages[1].code[: stages[1].code.index("o_color = ")].count("\n") + 1
    assert stages[1].locate(line) == "a.frag:6"


@pytest.mark.parametrize(
    ("declarations", "body"),
    [
        ("uniform sampler2D t_a;", "o_color = textureLod(t_a, vec2(0.0), 0.0);"),
        ("uniform bool u_a;", "o_color = vec4(u_a ? 1.0 : 0.0);"),
        ("uniform float u_a = 1.0;", "o_color = vec4(u_a);"),
        ("uniform float u_a;", "o_color = vec4(1.0);"),
        ("#if 1\nuniform vec2 u_a;\n#else\nuniform vec3 u_a;\n#endif", "o_color.r = u_a.x;"),
        ("uniform float u_a[3];", "int i = int(gl_FragCoord.x); o_color = vec4(u_a[i]);"),
        (f"uniform float u_a[{MOST_NUMBERS + 1}];", "o_color = vec4(u_a[0]);"),
        ("const int N = 2;\nuniform float u_a[N];", "o_color = vec4(u_a[0]);"),
    ],
)  # fmt: skip
def test_what_cannot_be_handed_on_stays_a_uniform(declarations, body):
    assert flat(declarations, body) is None


def test_vertices_with_attributes_hand_nothing_on():
    """There may be many of them, and each would read all uniforms."""
    vertex = VERTEX.replace("void", "in vec3 a_position;\nvoid")
    assert flat("uniform float u_a;", "o_color = vec4(u_a);", vertex) is None


def test_those_that_fit_are_handed_on():
    count = MOST_NUMBERS // 4 + 3
    names = [f"u_{i}" for i in range(count)]
    declarations = "\n".join(f"uniform vec4 {name};" for name in names)
    _, fragment = flat(declarations, f"o_color = {' + '.join(names)};")
    assert fragment.code.count("flat in vec4") == MOST_NUMBERS // 4
    assert fragment.code.count("uniform vec4") == 3


def test_a_program_of_many_uniforms_sees_them_all(gl, shaders):
    count = MOST_NUMBERS // 4 + 8
    names = [f"u_{i}" for i in range(count)]
    declared = "".join(f"uniform vec4 {name};\n" for name in names)
    program = fullscreen_source(
        shaders, f"{HEAD}{declared}void main() {{ o_color = {' + '.join(names)}; }}\n"
    )
    values = {name: (1.0, 2.0, i, 0.5) for i, name in enumerate(names)}
    found = draw(gl, program, values)
    np.testing.assert_array_equal(found, np.sum(list(values.values()), axis=0))


@pytest.mark.parametrize("value", [np.inf, -np.inf, 1e-38, -0.0, 3.4e38, 16777217.0])
def test_numbers_arrive_bit_for_bit(gl, shaders, value):
    program = fullscreen_source(
        shaders, f"{HEAD}uniform float u_a;\nvoid main() {{ o_color = vec4(u_a); }}\n"
    )
    found = draw(gl, program, {"u_a": value})
    np.testing.assert_array_equal(
        found.view(np.uint32), np.full(4, value, np.float32).view(np.uint32)
    )


def test_rows_of_an_array_arrive(gl, shaders):
    rows = np.arange(12.0).reshape(3, 4)
    program = fullscreen_source(
        shaders,
        f"{HEAD}#define ROWS 3\nuniform vec4 u_rows[ROWS];\n"
        "vec4 last(vec4 rows[ROWS]) { return rows[ROWS - 1]; }\n"
        "void main() { o_color = last(u_rows) - u_rows[0]; }\n",
    )
    np.testing.assert_array_equal(draw(gl, program, {"u_rows": rows}), rows[2] - rows[0])


def test_programs_are_linked_so_where_the_processor_draws(gl, shaders, monkeypatch):
    linked = []
    link = program_module.link_stages

    def noted(context, vertex, fragment):
        linked.append(fragment.code)
        return link(context, vertex, fragment)

    monkeypatch.setattr(program_module, "link_stages", noted)
    fullscreen_source(
        shaders,
        f"{HEAD}uniform float u_own;\nvoid main() {{ o_color = vec4(u_own, 7.0, 0.0, 0.0); }}\n",
    )
    if not shaders.computes:
        assert [("flat_u_own" in code) for code in linked] == [draws_on_cpu(gl)]


def test_a_fault_is_told_by_the_names_of_the_source(gl, shaders):
    with pytest.raises(ShaderError, match=r"<test>:4: .*vec2") as error:
        fullscreen_source(shaders, f"{HEAD}uniform vec2 u_a;\nvoid main() {{ o_color = u_a; }}\n")
    assert "flat_" not in str(error.value)


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
