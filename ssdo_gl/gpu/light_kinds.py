"""``lights/kinds.glsl``, which chooses between the kinds of lights, made from their list."""

from __future__ import annotations

from collections.abc import Iterable

from ssdo_gl.scene.lights import KINDS, Form, Light

LIGHT_KINDS_FILE = "lights/kinds.glsl"

# Return type, name, parameters and the answer for a kind that is not listed: of lights
# with an area, and of all others. See lights/lights.glsl.
_OF_AREAS = (
    ("vec3", "irradiance", "Light light, vec3 p_vs, vec3 n_vs, vec3 m_vs", "vec3(0.0)"),
    ("float", "distance", "Light light, vec3 p_vs, vec3 w", "FLOAT_MAX"),
    ("vec3", "point", "Light light, vec2 u", "light.place_vs"),
    ("vec3", "normal", "Light light, vec3 p_vs", "vec3(0.0)"),
)
_OF_OTHERS = (("float", "falloff", "Light light, vec3 to_light", "0.0"),)


def light_kinds_source() -> str:
    """Return the text of ``lights/kinds.glsl``."""
    kinds = list(KINDS.values())
    areas = [kind for kind in kinds if kind.form is Form.AREA]
    others = [kind for kind in kinds if kind.form is not Form.AREA]
    lines = [f"#define {_number(kind)} {number}" for number, kind in enumerate(kinds)]
    lines += [f'#include "lights/{kind.kind}.glsl"' for kind in kinds]
    forms = ((kind, f"FORM_{kind.form.name}") for kind in kinds)
    lines += _choice("int", "light_form(int kind)", "kind", forms, "-1")
    for prefix, chosen, functions in (("area", areas, _OF_AREAS), ("light", others, _OF_OTHERS)):
        for result, name, parameters, nothing in functions:
            arguments = ", ".join(part.split()[1] for part in parameters.split(", "))
            calls = ((kind, f"{kind.kind}_{name}({arguments})") for kind in chosen)
            head = f"{prefix}_{name}({parameters})"
            lines += _choice(result, head, "light.kind", calls, nothing)
    return "\n".join(lines) + "\n"


def _number(kind: type[Light]) -> str:
    return f"LIGHT_{kind.kind.upper()}"


def _choice(
    result: str, head: str, of: str, cases: Iterable[tuple[type[Light], str]], nothing: str
) -> list[str]:
    """Return the lines of a function that chooses by kind."""
    tests = [f"    if ({of} == {_number(kind)}) return {value};" for kind, value in cases]
    return [f"{result} {head}", "{", *tests, f"    return {nothing};", "}"]
