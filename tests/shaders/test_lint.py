"""Every shader, with every value of its switches, against a second compiler's front end.

glslangValidator is stricter than drivers about GLSL 3.30 core, so a shader that it
accepts has a chance on hardware that nobody tested on.
"""

from __future__ import annotations

import dataclasses
import itertools
import os
import re
import shutil
import subprocess
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from ssdo_gl import resources
from ssdo_gl.gpu.compute import compute_source, kernel_source, visible_surface_source
from ssdo_gl.gpu.shader import LIGHT_KINDS_FILE, light_kinds_source
from ssdo_gl.gpu.shader_source import (
    FlatSource,
    ShaderError,
    check_varyings,
    flatten,
    strip_comments,
)
from ssdo_gl.settings.estimators import ESTIMATORS

ROOT = Path(str(resources.folder("shaders")))
FILES = sorted(p.relative_to(ROOT).as_posix() for p in ROOT.rglob("*") if p.is_file())
LIBRARIES = [name for name in FILES if name.endswith(".glsl")]
STAGES = [name for name in FILES if name not in LIBRARIES]
# Cut-outs remove the surface itself, so nothing may be written there.
MAY_DISCARD = {"passes/gbuffer.frag", "effects/shadow_map.frag", "effects/back_faces.frag"}
# What needs a rasterizer, or is drawn to the screen itself.
RASTERIZED = {
    *("passes/gbuffer.frag", "passes/copy.frag", "effects/shadow_map.frag"),
    *("effects/back_faces.frag", "window/present.frag"),
    *("window/error_colors.frag", "window/follow.frag"),
}

PROJECTIONS = [
    {"projection": f"projections/{name}.glsl"} for name in ("perspective", "orthographic")
]

_MACRO = re.compile(r"^\s*#\s*define\s+(\w+)(?:\s+(-?\d+)\s*$)?", re.MULTILINE)
_CONDITION = re.compile(r"^\s*#\s*(?:el)?if\s+(.*)$", re.MULTILINE)
_CONSTANT = re.compile(r"\bconst\s+\w+\s+(\w+)")
_CAPITALS = re.compile(r"\b[A-Z][A-Z0-9_]{2,}\b")
_COMPARISON = re.compile(r"\b([A-Z][A-Z0-9_]*)\s*([=!]=|[<>]=?)\s*(\w+)")


def read(name: str) -> str:
    if name == LIGHT_KINDS_FILE:
        return light_kinds_source()
    return (ROOT / name).read_text(encoding="utf-8")


# What stands behind an include of a shader: one of the files in a folder named after it.
CHOICES = ("beyond_screen", "shadow_edge", "last_stage")


def choices_of(name: str) -> list[dict[str, str]]:
    """Return the sets of files that may stand behind the ``#include <name>`` of a shader."""
    # Those of mere visibility cannot say what light a blocker sends.
    needs_light = name in ("effects/bounce.frag", "effects/directional.frag")
    able = [e for e in ESTIMATORS.values() if e.gives_light or not needs_light]
    takes_one = '#include "screen_space/estimator.glsl"' in read(name)
    estimators = [dict(estimator.choices) for estimator in able] if takes_one else [{}]
    others = [
        [{key: f"{key}s/{path.name}"} for path in sorted((ROOT / f"{key}s").iterdir())]
        for key in CHOICES
        if f"#include <{key}>" in read(name)
    ]
    return [
        {key: value for part in parts for key, value in part.items()}
        for parts in itertools.product(PROJECTIONS, estimators, *others)
    ]


def unchecked(name: str, choices: dict[str, str] | None = None) -> str:
    """Return the code of a shader and all it includes, before defines are checked."""
    chosen = choices_of(name)[0] if choices is None else choices
    return _unchecked(name, tuple(chosen.items()))


@cache
def _unchecked(name: str, choices: tuple[tuple[str, str], ...]) -> str:
    # Any capitalised word counts as defined, so that flatten's own check stays silent.
    words = {word for file in FILES for word in _CAPITALS.findall(read(file))}
    lines = flatten(name, read, dict.fromkeys(words, 1), dict(choices)).code.splitlines()
    return "\n".join(line for line in lines[1 + len(words) :])


def switches(code: str) -> dict[str, set[int]]:
    """Return the defines that `code` expects from outside, with the values it compares.

    A name in a bare ``#if`` is tried as 0 and 1; one that is compared for equality as
    each value it is compared with (and as another, if that is a single one); one that is
    compared for order on both sides; the location of an output as 0 and a number of its
    own; any other (a loop bound) as 1.
    """
    numbers = {name: int(value) for name, value in _MACRO.findall(code) if value}
    inside = {name for name, _ in _MACRO.findall(code)} | set(_CONSTANT.findall(code))
    outside = {n for n in _CAPITALS.findall(code) if n not in inside and n[:3] != "GL_"}
    found: dict[str, set[int]] = {name: set() for name in outside}
    for condition in _CONDITION.findall(code):
        comparisons = _COMPARISON.findall(condition)
        for name in set(_CAPITALS.findall(condition)) & outside - {n for n, *_ in comparisons}:
            found[name] |= {0, 1}
        for name, operator, value in comparisons:
            number = int(value) if value.isdigit() else numbers.get(value)
            if name in outside and number is not None:
                step = {">": 1, "<=": 1, "<": -1, ">=": -1}.get(operator, 0)
                found[name] |= {number, number + step}
    for name, values in found.items():
        if len(values) < 2:
            found[name] = values | ({0} if values == {1} else {1})
    locations = sorted(name for name in found if name.endswith("_LOCATION"))
    return found | {name: {0, i + 1} for i, name in enumerate(locations)}


def variants(code: str) -> list[dict[str, int]]:
    """Return sets of defines in which every switch takes each of its values once."""
    found = switches(code)
    base = {name: max(values) for name, values in found.items()}
    result = [base]
    for name, values in sorted(found.items()):
        result += [{**base, name: value} for value in sorted(values - {base[name]})]
    low = {name: min(values) for name, values in found.items()}
    return result if low in result else [*result, low]


def known_by(code: str, defines: dict[str, int]) -> dict[str, int]:
    return {name: value for name, value in defines.items() if re.search(rf"\b{name}\b", code)}


def partner(fragment: str, flat: FlatSource, defines: dict[str, int]) -> FlatSource:
    """Return the vertex shader that writes what `fragment` reads under `defines`."""
    own = Path(fragment).with_suffix(".vert").as_posix()
    candidates = [own] if own in STAGES else ["passes/fullscreen.vert", *STAGES]
    faults = []
    for name in candidates:
        if not name.endswith(".vert"):
            continue
        needed = dict.fromkeys(switches(unchecked(name)), 1) | defines
        vertex = flatten(name, read, known_by(unchecked(name), needed))
        try:
            check_varyings(vertex, flat)
        except ShaderError as fault:
            faults.append(str(fault))
        else:
            return vertex
    raise AssertionError("; ".join(faults))


@pytest.fixture(scope="session")
def validator():
    """The path of glslangValidator; in CI its absence is a failure."""
    path = shutil.which("glslangValidator")
    if path is None:
        advice = "glslangValidator is not installed (Debian: apt-get install glslang-tools)"
        if os.environ.get("CI", "").lower() in ("1", "true"):
            pytest.fail(advice)
        pytest.skip(advice)
    return path


def validate(validator: str, folder: Path, *sources: FlatSource, link: bool = False) -> str:
    """Return what glslang has against `sources`, linked or each by itself; empty if nothing.

    To begin takes it 80 ms, to read one of our shaders 8 ms.
    """
    paths = []
    for number, source in enumerate(sources):
        paths.append(folder / f"{number:04}{Path(source.name).suffix}")
        paths[-1].write_text(source.text, encoding="utf-8")
    answer = subprocess.run(
        [validator, *(["-l"] if link else []), *map(str, paths)],
        capture_output=True,
        text=True,
        check=False,
    )
    if answer.returncode == 0:
        return ""
    # It names each file, then what is wrong with it, as file 0 if nothing is linked.
    at_fault, lines = sources[0], []
    for line in (answer.stdout + answer.stderr).splitlines():
        for source, path in zip(sources, paths, strict=True):
            if str(path) in line:
                at_fault, line = source, line.replace(str(path), "0")
        if line.strip() not in ("", "0"):
            lines.append(at_fault.translate_log(line))
    return "\n".join(lines) or "glslangValidator failed without a message"


def variants_of(name: str) -> Iterator[tuple[FlatSource, ...]]:
    """Yield a shader in every variant, with the vertex shader of a fragment shader."""
    for choices in choices_of(name):
        for defines in variants(unchecked(name, choices)):
            source = flatten(name, read, defines, choices)
            if name.endswith(".frag"):
                yield partner(name, source, defines), source
            else:
                yield (kernel_source(source) if name.endswith(".comp") else source,)


@pytest.mark.parametrize("name", STAGES)
def test_shader_is_valid_glsl_in_every_variant(name, validator, tmp_path):
    every = list(variants_of(name))
    # One of each: vertex shaders have few switches.
    sources = {source.text: source for stages in every for source in stages}
    assert validate(validator, tmp_path, *sources.values()) == ""
    if name.endswith(".frag"):
        for stages in (every[0], every[-1]):
            assert validate(validator, tmp_path, *stages, link=True) == ""


def test_what_can_compute_is_a_valid_compute_shader(validator, tmp_path):
    """Derivatives, too, which no software driver compiles there."""
    sources = []
    for name in (name for name in STAGES if name.endswith(".frag")):
        choices = choices_of(name)[0]
        source = compute_source(flatten(name, read, variants(unchecked(name, choices))[0], choices))
        if source is None:
            assert name in RASTERIZED
        else:
            sources.append(dataclasses.replace(source, name=name.replace(".frag", ".comp")))
    assert validate(validator, tmp_path, *sources) == ""


def test_the_gbuffer_is_a_valid_compute_shader_in_every_variant(validator, tmp_path):
    name, sources = "passes/gbuffer.frag", []
    for choices in PROJECTIONS:
        for defines in variants(unchecked(name, choices)):
            # The rasterizer's own, before it.
            defines |= {"HAS_ALPHA_CUTOUT": 0, "WIDE_DEPTH_RANGE": 0}
            fragment = flatten(name, read, defines, choices)
            source = visible_surface_source(partner(name, fragment, defines), fragment)
            sources.append(dataclasses.replace(source, name="gbuffer.comp"))
    assert validate(validator, tmp_path, *sources) == ""


@pytest.mark.parametrize("name", [*STAGES, *LIBRARIES])
def test_shader_keeps_the_house_rules(name):
    code = own_code(name)
    assert not re.search(r"\bacos\s*\(", code), "acos is wrong by 1.6e-4 on Mesa"
    if name not in MAY_DISCARD:
        assert not re.search(r"\bdiscard\b", code), "background pixels hold neutral values"
    for kind, prefix in (
        (r"uniform\s+(?!\w*sampler)\w+", "u_"),
        (r"uniform\s+\w*sampler\w+", "t_"),
    ):
        for variable in re.findall(rf"\b{kind}\s+(\w+)", code):
            assert variable.startswith(prefix), f"{variable} should start with {prefix}"
    ways = {
        ".vert": {"in": ("a_",), "out": ("v_",)},
        ".frag": {"in": ("v_",), "out": ("o_",)},
        ".glsl": {"in": ("a_", "v_"), "out": ("v_", "o_")},
        ".comp": {"in": (), "out": ()},
    }[Path(name).suffix]
    pattern = r"^\s*(?:layout\s*\([^)]*\)\s*)?(?:flat\s+)?(in|out)\s+\w+\s+(\w+)[^,();]*;"
    for way, variable in re.findall(pattern, code, re.MULTILINE):
        assert variable.startswith(ways[way]), f"{variable}: prefix {ways[way]}"


def own_code(name: str) -> str:
    """Return the code of one file, comments blanked, includes left out."""
    return strip_comments(read(name))


def has_main(name: str) -> bool:
    return bool(re.search(r"\bvoid\s+main\s*\(", own_code(name)))


def test_programs_have_a_main_and_libraries_do_not():
    assert [name for name in STAGES if not has_main(name)] == []
    assert [name for name in LIBRARIES if has_main(name)] == []


def test_every_library_is_used_by_a_program():
    used = {
        file
        for name in STAGES
        for choices in choices_of(name)
        for file, _ in flatten_all(name, choices).positions
    }
    assert sorted(set(LIBRARIES) - used) == []


def flatten_all(name: str, choices: dict[str, str]) -> FlatSource:
    return flatten(name, read, {**variants(unchecked(name, choices))[0]}, choices)


# The lint itself must be able to fail.


def test_switches_are_found_with_their_values():
    code = (
        "#define KIND_B 4\nconst float RADIUS = 1.0;\n#if KIND == 2 || KIND == KIND_B\n#endif\n"
        "#if HAS_SUN && !HAS_FOG\n#elif ORDER > 3\n#elif SINGLE == 2\n#elif ONE != 1\n#endif\n"
        "for (int i = 0; i < COUNT; ++i) x += RADIUS;\n"
    )
    assert switches(code) == {
        "KIND": {2, 4}, "HAS_SUN": {0, 1}, "HAS_FOG": {0, 1}, "COUNT": {1}, "ORDER": {3, 4},
        "SINGLE": {1, 2}, "ONE": {0, 1},
    }  # fmt: skip


def test_every_value_of_every_switch_is_tried():
    tried = variants("#if AAA\n#endif\n#if BBB == 2\n#endif\n")
    assert {v["AAA"] for v in tried} == {0, 1} and {v["BBB"] for v in tried} == {1, 2}


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("void main() { o_x = vec4(lost); }", "a.frag:3: error: 'lost'"),
        ("void main() { float x = 1; x = texture2DRect(0); }", "a.frag:3: error"),
        ("void main() { o_x = vec4(0.0); }\nfloat f( { }", "a.frag:4: error"),
    ],
)
def test_faulty_shader_is_found_at_its_line(validator, tmp_path, code, message):
    text = f"#version 330 core\nlayout(location = 0) out vec4 o_x;\n{code}\n"
    source = flatten("a.frag", lambda _: text)
    vertex = flatten("passes/fullscreen.vert", read)
    assert message in validate(validator, tmp_path, vertex, source)
    assert message in validate(validator, tmp_path, vertex, source, link=True)
