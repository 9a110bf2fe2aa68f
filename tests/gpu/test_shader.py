"""The library of shaders: errors that can be found, caching, reload."""

from __future__ import annotations

import pytest
from gpu.single_pixel import HEAD, draw
from program_of_text import fullscreen_source

from ssdo_gl.gpu.shader import ShaderError, ShaderLibrary


def test_compile_error_names_file_and_line_of_an_include(library, tmp_path):
    (tmp_path / "lib" / "bad.glsl").write_text("\n\nfloat f() { return nonsense; }\n")
    (tmp_path / "a.frag").write_text(
        HEAD + '#include "lib/bad.glsl"\nvoid main() { o_color = vec4(f()); }\n'
    )
    with pytest.raises(ShaderError, match=r"^lib/bad\.glsl:3: .*nonsense"):
        library.fullscreen("a.frag", {})


def test_compile_error_after_an_include_names_the_includer(library, tmp_path):
    (tmp_path / "lib" / "good.glsl").write_text("float f() { return 1.0; }\n")
    (tmp_path / "a.frag").write_text(
        HEAD + '#include "lib/good.glsl"\n\nvoid main() { o_color = oops; }\n'
    )
    with pytest.raises(ShaderError, match=r"^a\.frag:5: .*oops"):
        library.fullscreen("a.frag")


def test_compile_error_in_the_vertex_stage_names_that_file(library, tmp_path):
    (tmp_path / "a.vert").write_text("#version 330 core\nvoid main() { gl_Position = lost; }\n")
    (tmp_path / "a.frag").write_text(HEAD + "void main() { o_color = vec4(1.0); }\n")
    with pytest.raises(ShaderError, match=r"^a\.vert:2: .*lost"):
        library.program("a.vert", "a.frag")


def test_link_error_names_both_files(library, tmp_path):
    # Each stage is sound, and both declare the name; only the linker sees the conflict.
    (tmp_path / "a.vert").write_text(
        "#version 330 core\nuniform vec3 u_x;\nvoid main() { gl_Position = u_x.xyzz; }\n"
    )
    (tmp_path / "a.frag").write_text(HEAD + "uniform vec4 u_x;\nvoid main() { o_color = u_x; }\n")
    with pytest.raises(ShaderError, match=r"a\.vert \+ a\.frag: .*u_x"):
        library.program("a.vert", "a.frag")


@pytest.mark.parametrize(
    ("declaration", "fault"),
    [("in vec3 v_gone;", "does not write it"), ("flat in int v_uv;", "writes it as vec2")],
)
def test_varying_without_its_writer_is_refused(shaders, declaration, fault):
    text = HEAD + declaration + "\nvoid main() { o_color = vec4(0.0); }\n"
    with pytest.raises(ShaderError, match=rf"^<test>:3: in .*: passes/fullscreen\.vert {fault}"):
        fullscreen_source(shaders, text)


def test_define_reaches_the_shader_and_a_stray_one_is_refused(gl, library, tmp_path):
    (tmp_path / "a.frag").write_text(HEAD + "void main() { o_color = vec4(float(COUNT)); }\n")
    assert draw(gl, library.fullscreen("a.frag", {"COUNT": 0}))[0] == 0.0
    assert draw(gl, library.fullscreen("a.frag", {"COUNT": 5}))[0] == 5.0
    with pytest.raises(ShaderError, match="COUNTS is never mentioned; did you mean 'COUNT'"):
        library.fullscreen("a.frag", {"COUNTS": 5, "COUNT": 5})


def test_programs_are_compiled_once(library, tmp_path):
    (tmp_path / "a.frag").write_text(HEAD + "void main() { o_color = vec4(float(A + B)); }\n")
    first = library.fullscreen("a.frag", {"A": 1, "B": 2})
    assert library.fullscreen("a.frag", {"B": 2, "A": 1}) is first
    assert library.fullscreen("a.frag", {"A": 1, "B": 3}) is not first
    text = HEAD + "void main() { o_color = vec4(1.0); }\n"
    assert fullscreen_source(library, text) is fullscreen_source(library, text)
    assert fullscreen_source(library, text) is not fullscreen_source(library, text + "\n")


def test_reload_takes_edits_also_in_includes(gl, library, tmp_path):
    (tmp_path / "lib" / "value.glsl").write_text("const float VALUE = 1.0;\n")
    (tmp_path / "a.frag").write_text(
        HEAD + '#include "lib/value.glsl"\nvoid main() { o_color = vec4(VALUE); }\n'
    )
    program = library.fullscreen("a.frag")
    linked = program.gl
    assert library.reload() == []
    assert program.gl is linked, "nothing changed, so nothing is compiled"
    assert draw(gl, program)[0] == 1.0
    (tmp_path / "lib" / "value.glsl").write_text("const float VALUE = 2.0;\n")
    assert library.reload() == []
    assert program.gl is not linked
    assert draw(gl, program)[0] == 2.0


def test_reload_keeps_the_last_good_program(gl, library, tmp_path):
    good = HEAD + "uniform float u_x;\nvoid main() { o_color = vec4(u_x); }\n"
    (tmp_path / "a.frag").write_text(good)
    program = library.fullscreen("a.frag")
    assert draw(gl, program, {"u_x": 3.0})[0] == 3.0
    (tmp_path / "a.frag").write_text(HEAD + "void main() { o_color = broken; }\n")
    (fault,) = library.reload()
    assert "a.frag:3" in str(fault) and "broken" in str(fault)
    assert draw(gl, program, {"u_x": 4.0})[0] == 4.0
    (tmp_path / "a.frag").unlink()
    (fault,) = library.reload()
    assert 'cannot find the shader "a.frag"' in str(fault)
    (tmp_path / "a.frag").write_text(good.replace("vec4(u_x)", "vec4(-u_x)"))
    assert library.reload() == []
    assert draw(gl, program, {"u_x": 5.0})[0] == -5.0


def test_shipped_shaders_are_the_default_root(gl):
    fullscreen_source(
        ShaderLibrary(gl),
        HEAD + '#include "lib/constants.glsl"\nvoid main() { o_color = vec4(PI); }\n',
    )
