"""Uniforms handed to fragments as flat inputs: the same values, in the same lines."""

from __future__ import annotations

import numpy as np
import pytest
from gpu.single_pixel import HEAD, draw
from program_of_text import fullscreen_source

from ssdo_gl.gpu import program as program_module
from ssdo_gl.gpu.context import draws_on_cpu
from ssdo_gl.gpu.shader import ShaderError
from ssdo_gl.gpu.shader_source import flatten
from ssdo_gl.gpu.software.flat_uniforms import MOST_NUMBERS, with_flat_uniforms

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
