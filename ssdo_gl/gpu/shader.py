"""The library of shaders: programs by file name, compiled once and again when files change.

One of its files, which chooses between the kinds of lights, is made from their list.
"""

from __future__ import annotations

import copy
from collections.abc import Iterable, Mapping
from importlib.resources.abc import Traversable

import moderngl

from ssdo_gl import resources
from ssdo_gl.gpu.compute import (
    Kernel,
    compute_source,
    kernel_source,
    visible_surface_source,
)
from ssdo_gl.gpu.context import draws_on_cpu
from ssdo_gl.gpu.program import Program, Translation, digest_of
from ssdo_gl.gpu.shader_source import (
    FlatSource,
    ShaderError,
    check_mentioned,
    check_varyings,
    flatten,
)
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


__all__ = ["ShaderError", "ShaderLibrary"]

_NO_DEFINES: Mapping[str, int] = {}
_NO_CHOICES: Mapping[str, str] = {}
FULLSCREEN = "passes/fullscreen.vert"
USUAL_CHOICES: Mapping[str, str] = {"projection": "projections/perspective.glsl"}
# On llvmpipe a lookup at a texel's centre takes .56 of the time of a fetch, which asks whether the
# texel is there. All textures that are fetched from look up the nearest texel.
_ON_CPU: Mapping[str, str] = {
    "texelFetch(image, texel, level)": (
        "textureLod(image, (vec2(texel) + 0.5) * (1.0 / vec2(textureSize(image, 0))), 0.0)"
    ),
    # See `screen_space/estimator.glsl`.
    "MOST_TOGETHER": "4",
}
# Files of both stages, defines and choices, and how it may be a compute shader.
_ChoiceKey = tuple[tuple[str, str], ...]
_ProgramKey = tuple[str, str, tuple[tuple[str, int], ...], _ChoiceKey, Translation | None]


class ShaderLibrary:
    """Programs by file name, compiled once for each set of defines.

    Parameters
    ----------
    root : Traversable, optional
        Where the files lie; the shipped shaders if not given.
    computes : bool
        Run full-screen shaders as compute shaders, where they can: `Device.computes`.
    """

    def __init__(
        self,
        gl: moderngl.Context,
        root: Traversable | None = None,
        *,
        computes: bool = False,
    ) -> None:
        self._gl = gl
        self.computes = computes
        self._macros = _ON_CPU if draws_on_cpu(gl) else _NO_CHOICES
        self._root = resources.folder("shaders") if root is None else root
        self._choices = USUAL_CHOICES
        self._by_name: dict[_ProgramKey, Program] = {}
        # What was asked for before, and with which other choices.
        self._asked: dict[_ProgramKey, Program] = {}
        self._choosing: dict[tuple[tuple[str, str], ...], ShaderLibrary] = {}
        self._kernels: dict[tuple[str, _ChoiceKey], Kernel] = {}

    def program(
        self,
        vertex: str,
        fragment: str,
        defines: Mapping[str, int] = _NO_DEFINES,
        choices: Mapping[str, str] = _NO_CHOICES,
    ) -> Program:
        """Return the program of two files, e.g. ``"passes/gbuffer.vert", "passes/gbuffer.frag"``.

        Parameters
        ----------
        choices : mapping of str to str
            The file behind each ``#include <name>``, where it is not the library's.

        Raises
        ------
        ShaderError
            If a file is missing, does not compile, never mentions a define, or reads
            a varying that the other does not write.
        """
        return self._program(vertex, fragment, defines, choices, None)

    def _program(
        self,
        vertex: str,
        fragment: str,
        defines: Mapping[str, int],
        choices: Mapping[str, str],
        translate: Translation | None,
    ) -> Program:
        # As it is asked for every frame, in the order in which it was written down.
        asked = (vertex, fragment, tuple(defines.items()), tuple(choices.items()), translate)
        if (known := self._asked.get(asked)) is not None:
            return known
        chosen = {**self._choices, **choices}
        key = (
            vertex,
            fragment,
            tuple(sorted(defines.items())),
            tuple(sorted(chosen.items())),
            translate,
        )
        if key not in self._by_name:
            stages = self._flatten(vertex, fragment, defines, chosen)
            self._by_name[key] = Program(self._gl, *stages, translate)
        self._asked[asked] = self._by_name[key]
        return self._by_name[key]

    def fullscreen(
        self,
        fragment: str,
        defines: Mapping[str, int] = _NO_DEFINES,
        choices: Mapping[str, str] = _NO_CHOICES,
    ) -> Program:
        """Return the program of a fragment shader for `draw_fullscreen`."""
        way = _fullscreen if self.computes else None
        return self._program(FULLSCREEN, fragment, defines, choices, way)

    def visible_surface(
        self, vertex: str, fragment: str, defines: Mapping[str, int] = _NO_DEFINES
    ) -> Program:
        """Return a program that does for triangles whose numbers are known what these two do.

        Without `compute`, where the driver does not link it.
        """
        return self._program(vertex, fragment, defines, _NO_CHOICES, visible_surface_source)

    def kernel(self, name: str) -> Kernel:
        """Return a compute shader of a file of its own, e.g. ``"rasterizer/draw_blocks.comp"``.

        Raises
        ------
        ShaderError
            If the file is missing or does not compile.
        """
        key = name, tuple(sorted(self._choices.items()))
        if key not in self._kernels:
            self._kernels[key] = Kernel(self._gl, self._kernel_source(*key))
        return self._kernels[key]

    def _kernel_source(self, name: str, choices: _ChoiceKey) -> FlatSource:
        return kernel_source(flatten(name, self._read, {}, dict(choices)))

    def choosing(self, choices: Mapping[str, str]) -> ShaderLibrary:
        """Return this library, programs shared, with other files behind its includes."""
        key = tuple(choices.items())
        if key not in self._choosing:
            other = self._choosing[key] = copy.copy(self)
            other._choices = {**self._choices, **choices}
            other._asked, other._choosing = {}, {}
        return self._choosing[key]

    def reload(self) -> list[ShaderError]:
        """Compile again what changed on disk, and return what went wrong.

        A program that no longer compiles keeps its last good version.
        """
        faults: list[ShaderError] = []
        for (vertex, fragment, defines, choices, _), program in self._by_name.items():
            try:
                stages = self._flatten(vertex, fragment, dict(defines), dict(choices))
                if digest_of(*stages) != program.digest:
                    program.replace(*stages)
            except ShaderError as fault:
                faults.append(fault)
        for key, kernel in self._kernels.items():
            try:
                kernel.replace(self._kernel_source(*key))
            except ShaderError as fault:
                faults.append(fault)
        return faults

    def _flatten(
        self,
        vertex: str,
        fragment: str,
        defines: Mapping[str, int],
        choices: Mapping[str, str],
    ) -> tuple[FlatSource, FlatSource]:
        stages = (
            flatten(vertex, self._read, defines),
            flatten(fragment, self._read, defines, choices, self._macros),
        )
        _check(*stages, defines)
        return stages

    def _read(self, name: str) -> str:
        return read_shader(self._root, name)


def _fullscreen(vertex: FlatSource, fragment: FlatSource) -> FlatSource | None:
    return compute_source(fragment)


def read_shader(root: Traversable, name: str) -> str:
    """Return the text of a shader file below `root`, or of the one that is made."""
    if name == LIGHT_KINDS_FILE:
        return light_kinds_source()
    return root.joinpath(*name.split("/")).read_text(encoding="utf-8")


def _check(vertex: FlatSource, fragment: FlatSource, defines: Mapping[str, int]) -> None:
    check_mentioned(defines, (vertex, fragment))
    check_varyings(vertex, fragment)
