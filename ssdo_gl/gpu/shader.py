"""Loads, compiles and caches shader programs, and sets their uniforms strictly."""

from __future__ import annotations

import copy
import hashlib
from collections.abc import Callable, Mapping
from importlib.resources.abc import Traversable
from typing import Any

import moderngl

from ssdo_gl import resources
from ssdo_gl.gpu.compute import (
    ComputeProgram,
    Kernel,
    can_compute,
    compute_source,
    kernel_source,
    visible_surface_source,
)
from ssdo_gl.gpu.context import draws_on_cpu
from ssdo_gl.gpu.light_kinds import LIGHT_KINDS_FILE, light_kinds_source
from ssdo_gl.gpu.linking import link_compute, link_stages
from ssdo_gl.gpu.shader_source import (
    FlatSource,
    ShaderError,
    UniformDeclaration,
    check_mentioned,
    check_varyings,
    flatten,
)
from ssdo_gl.gpu.uniform import UniformSlot
from ssdo_gl.suggestion import suggestion

__all__ = ["Program", "ShaderError", "ShaderLibrary"]

_NO_DEFINES: Mapping[str, int] = {}
_NO_CHOICES: Mapping[str, str] = {}
FULLSCREEN = "passes/fullscreen.vert"
USUAL_CHOICES: Mapping[str, str] = {"projection": "projections/perspective.glsl"}
# On llvmpipe a lookup at a texel's centre takes .56 of the time of a fetch, which asks whether the
# texel is there. All textures that are fetched from look up the nearest texel.
_CPU_FETCH: Mapping[str, str] = {
    "texelFetch(image, texel, level)": (
        "textureLod(image, (vec2(texel) + 0.5) * (1.0 / vec2(textureSize(image, 0))), 0.0)"
    )
}
# How both stages become a compute shader; None: they do not, but are rasterized.
_Translation = Callable[[FlatSource, FlatSource], FlatSource | None]
# Files of both stages, defines and choices, and how it may be a compute shader.
_ChoiceKey = tuple[tuple[str, str], ...]
_ProgramKey = tuple[str, str, tuple[tuple[str, int], ...], _ChoiceKey, _Translation | None]
_NO_TEXTURES: Mapping[str, moderngl.Texture] = {}


class Program:
    """A linked program that refuses names its source does not declare.

    Attributes
    ----------
    gl : moderngl.Program
        Replaced by `ShaderLibrary.reload`; take it anew for every draw, and key what
        you cache about it (vertex arrays) by this object.
    compute : ComputeProgram or None
        What runs instead of a rasterized program, which `gl` then does not hold.
    digest : str
        Identifies the flattened sources.
    """

    def __init__(
        self,
        gl: moderngl.Context,
        vertex: FlatSource,
        fragment: FlatSource,
        translate: _Translation | None = None,
    ) -> None:
        self._context = gl
        self._translate = translate
        self._vertex_array: moderngl.VertexArray | None = None
        self._replace(vertex, fragment)

    def _replace(self, vertex: FlatSource, fragment: FlatSource) -> None:
        """Compile; on failure raise ShaderError and leave the program as it was."""
        compute = self._linked_compute(vertex, fragment)
        self.compute = None if compute is None else ComputeProgram(compute)
        linked: Any = compute
        if compute is None:
            linked = self.gl = link_stages(self._context, vertex, fragment)
        self.digest = _digest(vertex, fragment)
        self.name = f"{vertex.name} + {fragment.name}"
        self._declared = {**vertex.uniforms(), **fragment.uniforms()}
        # Attributes are members, too; built-in names, and those of compute shaders alone, are
        # not declared.
        self._members = frozenset(linked)
        active, samplers = [], []
        self._slots: dict[str, UniformSlot] = {}
        for name in linked:
            member, declaration = linked[name], self._declared.get(name)
            if declaration is None or not isinstance(member, moderngl.Uniform):
                continue
            active.append(name)
            if declaration.is_sampler:
                samplers.append(name)
            else:
                self._slots[name] = UniformSlot(self.name, name, declaration, member)
        # Fixed units: to change one texture leaves the others where they are.
        self._units = {name: unit for unit, name in enumerate(samplers)}
        self._samplers = frozenset(samplers)
        for name, unit in self._units.items():
            linked[name] = unit
        if self.compute is not None:
            self.compute.first_unit = len(self._units)
        self._unset = {name for name in active if not self._declared[name].has_initializer}
        if self._vertex_array is not None:
            self._vertex_array.release()
        self._vertex_array = None

    def _linked_compute(
        self, vertex: FlatSource, fragment: FlatSource
    ) -> moderngl.ComputeShader | None:
        source = None if self._translate is None else self._translate(vertex, fragment)
        if source is None or not can_compute(self._context, source):
            return None
        try:
            return link_compute(self._context, source)
        except ShaderError:
            # A rasterizer does the same; what is wrong with the shader it says as well.
            return None

    def set(
        self,
        uniforms: Mapping[str, object],
        textures: Mapping[str, moderngl.Texture] = _NO_TEXTURES,
    ) -> None:
        """Set uniforms and bind textures; those not named keep what they had.

        Parameters
        ----------
        uniforms : mapping of str to number, sequence or ndarray
            Matrices in the column-vector convention of `math3d` (``m[row, column]``).
        textures : mapping of sampler name to texture

        Raises
        ------
        ShaderError
            If a name is not declared in the source, or a value does not fit its type.
            A declared uniform that the driver optimised away is skipped.
        """
        slots, units = self._slots, self._units
        for name, value in uniforms.items():
            slot = slots.get(name)
            if slot is not None:
                # Most values are the very ones of the frame before: the driver has them.
                if value is not slot.constant or value is None:
                    slot.set(value)
            elif self._declaration(name).is_sampler:
                raise ShaderError(f"{self.name}: {name} is a sampler; give it among the textures")
        for name, texture in textures.items():
            unit = units.get(name)
            if unit is not None:
                texture.use(unit)
            elif not self._declaration(name).is_sampler:
                raise ShaderError(f"{self.name}: {name} is not a sampler but takes a value")
        if self._unset:
            self._unset.difference_update(uniforms, textures)

    def takes(self, name: str) -> bool:
        """Return whether the driver has an attribute or uniform of this name."""
        return name in self._members

    def check_complete(self, textures: Mapping[str, moderngl.Texture] | None = None) -> None:
        """Raise ShaderError if a uniform or sampler in use was never given a value.

        With `textures`, what was bound before does not count: between two draws, or two
        bands of one, a window may show its panel, which binds others.
        """
        if self._unset:
            raise ShaderError(f"{self.name}: never set: {', '.join(sorted(self._unset))}")
        if textures is not None and not self._samplers <= textures.keys():
            missing = ", ".join(sorted(self._samplers - textures.keys()))
            raise ShaderError(f"{self.name}: not given with this draw: {missing}")

    def empty_vertex_array(self) -> moderngl.VertexArray:
        """Return a vertex array without attributes, for shaders that use gl_VertexID."""
        if self._vertex_array is None:
            self._vertex_array = self._context.vertex_array(self.gl, [])
        return self._vertex_array

    def _declaration(self, name: str) -> UniformDeclaration:
        if name not in self._declared:
            hint = suggestion(name, self._declared, lists=False)
            raise ShaderError(f"{self.name}: no uniform is called {name}{hint}")
        return self._declared[name]


class ShaderLibrary:
    """Programs by file name, compiled once for each set of defines.

    Parameters
    ----------
    root : Traversable, optional
        Where the files lie; the shipped shaders if not given.
    choices : mapping of str to str
        The file behind each ``#include <name>`` that a program does not choose itself.
    computes : bool
        Run full-screen shaders as compute shaders, where they can: `Device.computes`.
    """

    def __init__(
        self,
        gl: moderngl.Context,
        root: Traversable | None = None,
        choices: Mapping[str, str] = USUAL_CHOICES,
        *,
        computes: bool = False,
    ) -> None:
        self._gl = gl
        self.computes = computes
        self._macros = _CPU_FETCH if draws_on_cpu(gl) else _NO_CHOICES
        self._root = resources.folder("shaders") if root is None else root
        self._choices = choices
        self._by_name: dict[_ProgramKey, Program] = {}
        self._by_content: dict[str, Program] = {}
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
        translate: _Translation | None,
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

    def fullscreen_source(
        self, text: str, defines: Mapping[str, int] = _NO_DEFINES, name: str = "<test>"
    ) -> Program:
        """Return a program whose fragment shader is `text`, under the same rules."""
        fragment = flatten(
            name,
            lambda n: text if n == name else self._read(n),
            defines,
            self._choices,
            self._macros,
        )
        vertex = flatten(FULLSCREEN, self._read, defines)
        _check(vertex, fragment, defines)
        digest = _digest(vertex, fragment)
        if digest not in self._by_content:
            way = _fullscreen if self.computes else None
            program = Program(self._gl, vertex, fragment, way)
            self._by_content[digest] = program
        return self._by_content[digest]

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
                if _digest(*stages) != program.digest:
                    program._replace(*stages)
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


def _digest(vertex: FlatSource, fragment: FlatSource) -> str:
    return hashlib.sha256(f"{vertex.text}\0{fragment.text}".encode()).hexdigest()
