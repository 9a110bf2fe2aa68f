"""A linked shader program, whose uniforms are set strictly."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

import moderngl

from ssdo_gl.gpu.compute import ComputeProgram, can_compute
from ssdo_gl.gpu.context import draws_on_cpu
from ssdo_gl.gpu.linking import link_compute, link_stages
from ssdo_gl.gpu.shader_source import FlatSource, ShaderError, UniformDeclaration
from ssdo_gl.gpu.software import with_flat_uniforms, with_image_reads
from ssdo_gl.gpu.uniform import UniformSlot
from ssdo_gl.wording import suggestion

# How both stages become a compute shader; None: they do not, but are rasterized.
Translation = Callable[[FlatSource, FlatSource], FlatSource | None]
_NO_TEXTURES: Mapping[str, moderngl.Texture] = {}


def digest_of(vertex: FlatSource, fragment: FlatSource) -> str:
    """Return what identifies the flattened sources of two stages."""
    return hashlib.sha256(f"{vertex.text}\0{fragment.text}".encode()).hexdigest()


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
        translate: Translation | None = None,
    ) -> None:
        self._context = gl
        self._translate = translate
        self._vertex_array: moderngl.VertexArray | None = None
        self.replace(vertex, fragment)

    def replace(self, vertex: FlatSource, fragment: FlatSource) -> None:
        """Compile these stages instead; on failure raise ShaderError and leave all as it was."""
        compute = self._linked_compute(vertex, fragment)
        self.compute = None if compute is None else ComputeProgram(compute)
        linked: Any = compute
        # Units of textures that are read as images.
        images: Mapping[str, int] = {}
        if compute is None:
            linked, images = self._linked_stages(vertex, fragment)
            self.gl = linked
        self._images = images
        self.digest = digest_of(vertex, fragment)
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
        self._units = {name: i for i, name in enumerate(n for n in samplers if n not in images)}
        self._samplers = frozenset(samplers)
        for name, unit in self._units.items():
            linked[name] = unit
        if self.compute is not None:
            self.compute.first_unit = len(self._units)
        self._unset = {name for name in active if not self._declared[name].has_initializer}
        if self._vertex_array is not None:
            self._vertex_array.release()
        self._vertex_array = None

    def _linked_stages(
        self, vertex: FlatSource, fragment: FlatSource
    ) -> tuple[moderngl.Program, Mapping[str, int]]:
        """Return the program, and the units of textures that it reads as images."""
        if draws_on_cpu(self._context):
            stage, images = with_image_reads(fragment)
            with suppress(ShaderError):
                flat = with_flat_uniforms(vertex, stage) or (vertex, stage)
                return link_stages(self._context, *flat), images
        # What is wrong with a shader is said of it as it was written.
        return link_stages(self._context, vertex, fragment), {}

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
        slots, units, images = self._slots, self._units, self._images
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
            elif name in images:
                texture.bind_to_image(images[name], read=True, write=False)
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
