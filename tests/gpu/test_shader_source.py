"""Flattening of shader sources; no OpenGL needed."""

from __future__ import annotations

import pytest

from ssdo_gl.gpu.shader_source import ShaderError, check_mentioned, flatten, strip_comments

HEAD = "#version 330 core\n"


def reader(files):
    def read(name):
        if name not in files:
            raise FileNotFoundError(name)
        return files[name]

    return read


def flat(text, defines=None, **libraries):
    files = {"a.frag": text, **{f"lib/{k}.glsl": v for k, v in libraries.items()}}
    return flatten("a.frag", reader(files), defines)


def body(source):
    """The flattened lines that hold any code, less the version."""
    return [line for line in source.code.splitlines()[1:] if line.strip()]


def where(source, text):
    """file:line of the flattened line that contains `text`."""
    number = next(i for i, line in enumerate(source.text.splitlines(), 1) if text in line)
    return source.locate(number)


def test_include_is_replaced_by_its_text_where_it_stands():
    source = flat(HEAD + '#include "lib/x.glsl"\nint b;\n', x="int a;\n")
    assert body(source) == ["int a;", "int b;"]


def test_each_file_is_included_once_also_through_others():
    source = flat(
        HEAD + '#include "lib/x.glsl"\n#include "lib/y.glsl"\n#include "lib/x.glsl"\n',
        x="int x;\n",
        y='#include "lib/x.glsl"\nint y;\n',
    )
    assert body(source) == ["int x;", "int y;"]


def test_include_cycles_end():
    source = flat(
        HEAD + '#include "lib/x.glsl"\n',
        x='#include "lib/y.glsl"\nint x;\n',
        y='#include "lib/x.glsl"\n#include "lib/y.glsl"\nint y;\n',
    )
    assert body(source) == ["int y;", "int x;"]


def test_lines_know_their_file_and_number():
    source = flat(
        "// a comment\n\n" + HEAD + "int before;\n" + '#include "lib/x.glsl"\nint after;\n',
        {"COUNT": 3},
        x='// lib\n#include "lib/y.glsl"\nint x = COUNT;\n',
        y="\n\nint y;",
    )
    assert where(source, "#version") == "a.frag:1"
    assert where(source, "before") == "a.frag:4"
    assert where(source, "int y") == "lib/y.glsl:3"
    assert where(source, "int x") == "lib/x.glsl:3"
    assert where(source, "after") == "a.frag:6"
    assert where(source, "#define COUNT 3") == "<define COUNT>:1"


def test_version_is_the_first_line_because_drivers_see_the_text_stripped():
    # moderngl strips leading blank lines before it compiles: the table would be off.
    source = flat("\n\n/* two\nlines */\n" + HEAD + "int a;\n")
    assert source.text.startswith("#version 330 core\n")
    assert where(source, "int a") == "a.frag:6"


def test_missing_include_names_the_includer_and_its_line():
    with pytest.raises(ShaderError, match=r'^a\.frag:3: cannot find the include "lib/no\.glsl"'):
        flat(HEAD + '\n#include "lib/no.glsl"\n')


def test_missing_shader_is_named():
    with pytest.raises(ShaderError, match=r'cannot find the shader "b\.frag"'):
        flatten("b.frag", reader({}))


def test_a_chosen_file_stands_behind_its_name():
    files = {
        "a.frag": HEAD + "#include <way>\nint b;\n",
        "x.glsl": "int x;\n",
        "y.glsl": "int y;\n",
    }
    for letter in "xy":
        chosen = flatten("a.frag", reader(files), {}, {"way": f"{letter}.glsl"})
        assert body(chosen) == [f"int {letter};", "int b;"]
        assert where(chosen, f"int {letter}") == f"{letter}.glsl:1"
    with pytest.raises(ShaderError, match=r"a\.frag:2: no file was chosen for #include <way>"):
        flatten("a.frag", reader(files), {}, {"other": "x.glsl"})
    with pytest.raises(ShaderError, match=r'a\.frag:2: cannot find the include "z.glsl"'):
        flatten("a.frag", reader(files), {}, {"way": "z.glsl"})


@pytest.mark.parametrize("line", ["#include <>", "#include lib/x.glsl", "#include", '#include ""'])
def test_malformed_include_is_refused(line):
    with pytest.raises(ShaderError, match=r"a\.frag:2: write #include"):
        flat(HEAD + line + "\n")


def test_include_inside_a_conditional_is_refused():
    with pytest.raises(ShaderError, match=r"a\.frag:3: an #include inside #if"):
        flat(HEAD + '#ifdef GL_core_profile\n#include "lib/x.glsl"\n#endif\n', x="")


@pytest.mark.parametrize(
    "comment", ['// #include "lib/no.glsl"', '/*\n#include "lib/no.glsl"\n#if NO\n*/', "// #if NO"]
)
def test_commented_directives_are_ignored(comment):
    assert body(flat(HEAD + comment + "\nint a;\n")) == ["int a;"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("int a;\n", r"a\.frag:1: a shader starts with #version 330 core"),
        ("#version 450\n", r"a\.frag:1: write #version 330 core, not '#version 450'"),
        ("int a;\n#version 330 core\n", r"a\.frag:2: #version 330 core must come before"),
        (HEAD + '#include "lib/x.glsl"\n', r"lib/x\.glsl:1: #version inside a file that a\.frag:2"),
    ],
)
def test_version_is_required_once_and_first(text, message):
    with pytest.raises(ShaderError, match=message):
        flat(text, x=HEAD)


@pytest.mark.parametrize("value", [0, 1, 7, True])
def test_integer_defines_are_written_also_zero(value):
    assert f"#define COUNT {int(value)}" in flat(HEAD, {"COUNT": value}).text


def test_negative_define_is_parenthesised():
    assert "#define SHIFT (-2)" in flat(HEAD, {"SHIFT": -2}).text


@pytest.mark.parametrize("value", [0.5, 1.0, "3", None])
def test_other_defines_are_refused(value):
    with pytest.raises(ShaderError, match=r"COUNT = .* is not an integer"):
        flat(HEAD, {"COUNT": value})


@pytest.mark.parametrize("name", ["count", "2D", "A B", ""])
def test_defines_are_capitals(name):
    with pytest.raises(ShaderError, match="is not a name in capitals"):
        flat(HEAD, {name: 1})


def test_define_that_no_stage_mentions_is_refused_with_a_suggestion():
    source = flat(HEAD + "int a = STEP_COUNT; // STEPS\n", {"STEPS_COUNT": 1})
    with pytest.raises(ShaderError, match=r"a\.frag.*STEPS_COUNT.*did you mean 'STEP_COUNT'"):
        check_mentioned(["STEPS_COUNT"], [source])


def test_define_that_one_of_two_stages_mentions_is_accepted():
    stages = [flat(HEAD, {"COUNT": 1}), flat(HEAD + "int a = COUNT;\n", {"COUNT": 1})]
    check_mentioned(["COUNT"], stages)


def test_mention_must_be_the_whole_name():
    with pytest.raises(ShaderError):
        check_mentioned(["COUNT"], [flat(HEAD + "int COUNT_MAX;\n", {"COUNT": 1})])


@pytest.mark.parametrize(
    "condition",
    [
        "#ifdef MODE\n#endif\n#if MODE",
        "#if MODE == 1",
        "#if 1 && MODE",
        "#if 0\n#elif MODE\n",
        "#if defined(OTHER) && MODE",
    ],
)
def test_undefined_name_in_a_condition_is_refused(condition):
    with pytest.raises(ShaderError, match=r"a\.frag:\d: #(if|elif) uses MODE, which is not"):
        flat(HEAD + condition + "\n#endif\n")


def test_undefined_name_is_found_in_the_library_that_uses_it():
    with pytest.raises(ShaderError, match=r"^lib/x\.glsl:2: #if uses MODE"):
        flat(HEAD + '#include "lib/x.glsl"\n', x="\n#if MODE\n#endif\n")


def test_name_defined_after_its_use_is_refused():
    with pytest.raises(ShaderError, match=r"a\.frag:2"):
        flat(HEAD + "#if MODE\n#endif\n#define MODE 1\n")


@pytest.mark.parametrize(
    "text",
    [
        "#define MODE 1\n#if MODE\n#endif\n",
        "#ifdef MODE\n#if MODE > 2\n#endif\n#endif\n",
        "#if defined(MODE) && MODE > 2\n#endif\n",
        "#if defined MODE\n#elif 1\n#endif\n",
        "#ifndef MODE\n#define MODE 0\n#endif\n#if MODE\n#endif\n",
        "#if __VERSION__ >= 330 && GL_core_profile\n#endif\n",
    ],
)
def test_guarded_and_defined_names_are_accepted(text):
    flat(HEAD + text)


def test_injected_define_satisfies_a_condition():
    flat(HEAD + "#if MODE\n#endif\n", {"MODE": 0})


def test_strip_comments_keeps_lines():
    text = "a // b\n/* c\nd */ e /* f */ g\n"
    assert strip_comments(text).split() == ["a", "e", "g"]
    assert strip_comments(text).count("\n") == text.count("\n")


@pytest.mark.parametrize(
    ("log", "expected"),
    [
        ("0:3(7): error: syntax error", "lib/x.glsl:1: error: syntax error"),
        ("0(3) : error C1008: undefined", "lib/x.glsl:1: error C1008: undefined"),
        ("ERROR: 0:3: 'a' : undeclared", "lib/x.glsl:1: error: 'a' : undeclared"),
        ("WARNING: 0:5: odd", "a.frag:3: warning: odd"),
        ("0:99(1): error: beyond", "a.frag:?: error: beyond"),
        ("2 errors generated", "2 errors generated"),
    ],
)
def test_driver_logs_are_translated(log, expected):
    source = flat(HEAD + '#include "lib/x.glsl"\nint b;\n', x="int a;")
    # Blank are the lines where #version and #include stood.
    assert source.text.splitlines() == ["#version 330 core", "", "int a;", "", "int b;", ""]
    assert source.translate_log(log) == expected


def test_log_of_several_messages_keeps_their_order():
    source = flat(HEAD + "int a;\nint b;\n")
    log = "0:3(1): error: one\n\n0:4(1): error: two\n"
    assert source.translate_log(log) == "a.frag:2: error: one\na.frag:3: error: two"


def test_uniform_declarations_are_read():
    source = flat(
        HEAD + "uniform float u_a, u_b[4], u_c = float(1, 2);\n"
        "uniform highp mat3 u_view;\nuniform sampler2D t_image;\n"
        "uniform usampler2D t_bits; // uniform int u_not;\nuniform\n  ivec2\n  u_size;\n"
        "uniform Block { vec4 v; };\n"
    )
    found = source.uniforms()
    assert list(found) == ["u_a", "u_b", "u_c", "u_view", "t_image", "t_bits", "u_size"]
    assert [d.type for d in found.values()] == [
        "float", "float", "float", "mat3", "sampler2D", "usampler2D", "ivec2",
    ]  # fmt: skip
    assert found["u_b"].is_array and not found["u_a"].is_array
    assert found["u_c"].has_initializer and not found["u_b"].has_initializer
    assert found["t_bits"].is_sampler and not found["u_view"].is_sampler
