"""Programs on a device: uniforms and textures are set strictly."""

from __future__ import annotations

import moderngl
import numpy as np
import pytest
from gpu.image_texture import texture_from_image
from gpu.single_pixel import HEAD, draw
from program_of_text import fullscreen_source

from ssdo_gl.gpu.shader import ShaderError
from ssdo_gl.gpu.texture import make_texture

# One uniform of each kind with its value and the four numbers that the shader must see.
# m[column][row] in GLSL: the second column of the column-vector matrix below is (2, 5, 8).
MATRIX = np.arange(1.0, 10.0).reshape(3, 3)


KINDS = {
    "float u_x": (0.5, "vec4(u_x)", [0.5] * 4),
    "vec2 u_x": ((1, 2), "vec4(u_x, 0, 0)", [1, 2, 0, 0]),
    "vec3 u_x": (np.array([1.0, 2.0, 3.0]), "vec4(u_x, 0)", [1, 2, 3, 0]),
    "vec4 u_x": ([1, 2, 3, 4], "u_x", [1, 2, 3, 4]),
    "int u_x": (-3, "vec4(float(u_x))", [-3] * 4),
    "ivec2 u_x": ((-3, 2**24), "vec4(u_x, 0, 0)", [-3, 2**24, 0, 0]),
    "uint u_x": (2**31, "vec4(float(u_x >> 31))", [1] * 4),
    "uvec2 u_x": ((1, 2), "vec4(u_x, 0, 0)", [1, 2, 0, 0]),
    "bool u_x": (True, "vec4(u_x ? 1.0 : 0.0)", [1] * 4),
    "mat3 u_x": (MATRIX, "vec4(u_x * vec3(0, 1, 0), u_x[0][2])", [2, 5, 8, 7]),
    "mat2 u_x": ([[1, 2], [3, 4]], "vec4(u_x[0], u_x[1])", [1, 3, 2, 4]),
    "mat4 u_x": (np.diag([1, 2, 3, 4]), "u_x * vec4(1)", [1, 2, 3, 4]),
    "float u_x[3]": ([1, 2, 3], "vec4(u_x[0], u_x[1], u_x[2], 0)", [1, 2, 3, 0]),
    "vec2 u_x[2]": ([[1, 2], [3, 4]], "vec4(u_x[0], u_x[1])", [1, 2, 3, 4]),
    "mat3 u_x[2]": (np.stack([MATRIX, 2 * MATRIX]), "vec4(u_x[1] * vec3(0, 1, 0), u_x[0][2][0])",
                    [4, 10, 16, 3]),
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_uniforms_of_every_kind_arrive(gl, shaders, kind):
    value, expression, expected = KINDS[kind]
    program = fullscreen_source(
        shaders, HEAD + f"uniform {kind};\nvoid main() {{ o_color = {expression}; }}\n"
    )
    np.testing.assert_array_equal(draw(gl, program, {"u_x": value}), expected)


@pytest.mark.parametrize(
    ("kind", "value"),
    [
        ("float", (1.0, 2.0)),
        ("vec3", (1.0, 2.0)),
        ("vec2", (1.0, 2.0, 3.0)),
        ("mat3", np.eye(4)),
        ("mat3", np.arange(9.0)),
        ("int", 1.5),
        ("bool", 0.5),
    ],
)
def test_values_that_do_not_fit_are_refused(gl, shaders, kind, value):
    program = fullscreen_source(
        shaders,
        HEAD + f"uniform {kind} u_x;\nuniform float u_y;\n"
        f"void main() {{ o_color = u_x == {kind}(u_y) ? vec4(1.0) : vec4(0.0); }}\n",
    )
    with pytest.raises(ShaderError, match="u_x"):
        program.set({"u_x": value})


def test_array_that_is_too_short_is_refused_and_a_cut_tail_is_not(gl, shaders):
    program = fullscreen_source(
        shaders,
        HEAD + "uniform float u_x[4];\nvoid main() { o_color = vec4(u_x[0], u_x[1], 0, 0); }\n",
    )
    assert list(draw(gl, program, {"u_x": [1, 2, 3, 4]})) == [1, 2, 0, 0]
    with pytest.raises(ShaderError, match="u_x"):
        program.set({"u_x": [1]})


def test_name_that_the_source_does_not_declare_is_refused(gl, shaders):
    program = fullscreen_source(
        shaders, HEAD + "uniform float u_radius;\nvoid main() { o_color = vec4(u_radius); }\n"
    )
    with pytest.raises(ShaderError, match="no uniform is called u_radiu; did you mean 'u_radius'"):
        program.set({"u_radiu": 1.0})
    with pytest.raises(ShaderError, match="no uniform is called t_image"):
        program.set({}, {"t_image": make_texture(gl, (1, 1), 1, "f4")})


def test_declared_uniform_that_the_driver_drops_is_skipped(gl, shaders):
    program = fullscreen_source(
        shaders,
        HEAD + "uniform float u_unused;\nuniform sampler2D t_unused;\n"
        "void main() { o_color = vec4(1.0); }\n",
    )
    image = texture_from_image(gl, np.ones((1, 1)))
    assert draw(gl, program, {"u_unused": 1.0}, {"t_unused": image})[0] == 1.0


def test_samplers_and_values_are_not_interchangeable(gl, shaders):
    program = fullscreen_source(
        shaders,
        HEAD + "uniform float u_x;\nuniform sampler2D t_x;\n"
        "void main() { o_color = u_x * texelFetch(t_x, ivec2(0), 0); }\n",
    )
    with pytest.raises(ShaderError, match="t_x is a sampler"):
        program.set({"t_x": 0})
    with pytest.raises(ShaderError, match="u_x is not a sampler"):
        program.set({}, {"u_x": make_texture(gl, (1, 1), 1, "f4")})


def test_a_draw_is_given_all_of_its_textures(gl, shaders):
    """What an earlier call has bound may be something else by now."""
    program = fullscreen_source(
        shaders,
        HEAD + "uniform sampler2D t_a;\nuniform sampler2D t_b;\nvoid main() {\n"
        "  o_color.xy = vec2(texelFetch(t_a, ivec2(0), 0).r, texelFetch(t_b, ivec2(0), 0).r);\n"
        "  o_color.zw = vec2(0.0);\n}\n",
    )
    a, b, c = (texture_from_image(gl, np.full((1, 1), x)) for x in (1.0, 2.0, 3.0))
    assert list(draw(gl, program, {}, {"t_b": b, "t_a": a})) == [1, 2, 0, 0]
    with pytest.raises(ShaderError, match=r"not given with this draw: t_a$"):
        draw(gl, program, {}, {"t_b": c})
    assert list(draw(gl, program, {}, {"t_b": c, "t_a": a})) == [1, 3, 0, 0]


def test_initialised_uniform_need_not_be_set(gl, shaders):
    program = fullscreen_source(
        shaders, HEAD + "uniform float u_gain = 2.0;\nvoid main() { o_color = vec4(u_gain); }\n"
    )
    assert draw(gl, program)[0] == 2.0


@pytest.fixture
def written(monkeypatch):
    """The names of the uniforms that are written."""
    names = []
    write = moderngl.Uniform.write

    def recording(uniform, data):
        names.append(uniform.name)
        write(uniform, data)

    monkeypatch.setattr(moderngl.Uniform, "write", recording)
    return names


def test_values_that_stay_are_not_written_again(gl, library, tmp_path, written):
    text = HEAD + "uniform float u_x;\nuniform vec2 u_y;\n"
    (tmp_path / "a.frag").write_text(text + "void main() { o_color = vec4(u_x, u_y, 1.0); }\n")
    program = library.fullscreen("a.frag")
    for x, y in ((1.0, (2.0, 3.0)), (1, (2.0, 3.0)), (-0.0, (2.0, 4.0)), (0.0, (2.0, 4.0))):
        program.set({"u_x": x, "u_y": y})
        assert list(draw(gl, program)) == [x, *y, 1.0]
    # The same number written as an integer is the same; zero has two signs.
    assert written == ["u_x", "u_y", "u_x", "u_y", "u_x"]


@pytest.mark.parametrize("make", [list, np.array, lambda value: (np.array(value[0]), value[1])])
def test_a_value_that_was_changed_in_place_is_written(gl, shaders, written, make):
    program = fullscreen_source(
        shaders, HEAD + "uniform vec2 u_x;\nvoid main() { o_color = vec4(u_x.yx, 0, 0); }\n"
    )
    value = make([1.0, 2.0])
    assert list(draw(gl, program, {"u_x": value})) == [2, 1, 0, 0]
    if isinstance(value, tuple):
        value[0][...] = 5.0
    else:
        value[0] = 5.0
    assert list(draw(gl, program, {"u_x": value})) == [2, 5, 0, 0]
    # Where it is a compute shader, region and size are written besides.
    assert [name for name in written if name == "u_x"] == ["u_x", "u_x"]
