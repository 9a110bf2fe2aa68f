"""A compute shader that is none of a full-screen shader: of a file of its own."""

from __future__ import annotations

from collections.abc import Mapping

import moderngl

from ssdo_gl.gpu.linking import link_compute
from ssdo_gl.gpu.shader_source import FlatSource, ShaderError
from ssdo_gl.gpu.uniform import UniformSlot

# The most groups along the first axis of a dispatch that OpenGL grants.
_MOST_GROUPS = 65535


# A coordinate for what is shared with fragment shaders.
_HEAD = "#version 450 core\nvec4 compute_coordinate;"


def kernel_source(flat: FlatSource) -> FlatSource:
    """Return the shader in the version that has compute shaders."""

    def of(text: str) -> str:
        rest = text.split("\n", 1)[1]
        return f"{_HEAD}\n{rest.replace('gl_FragCoord', 'compute_coordinate')}"

    return FlatSource(flat.name, of(flat.text), of(flat.code), (("<compute>", 1), *flat.positions))


class Kernel:
    """A compute shader that refuses names its source does not declare.

    Raises
    ------
    ShaderError
        If it does not compile.
    """

    def __init__(self, gl: moderngl.Context, source: FlatSource) -> None:
        self._gl = gl
        self._link(source)

    def replace(self, source: FlatSource) -> None:
        """Take another source, if it is one; on failure raise ShaderError and stay as it was."""
        if source.text != self._source.text:
            self._link(source)

    def _link(self, source: FlatSource) -> None:
        linked = link_compute(self._gl, source)
        self._source, self._linked = source, linked
        self._declared = source.uniforms()
        self._slots: dict[str, UniformSlot] = {}
        for name in linked:
            member, declaration = linked[name], self._declared.get(name)
            if declaration is None or "image" in declaration.type:
                continue
            if isinstance(member, moderngl.Uniform):
                self._slots[name] = UniformSlot(source.name, name, declaration, member)

    def set(self, uniforms: Mapping[str, object]) -> None:
        """Give uniforms values; those that the driver optimised away are skipped.

        Raises
        ------
        ShaderError
            If a name is not declared in the source, or a value does not fit its type.
        """
        for name, value in uniforms.items():
            if name in self._slots:
                self._slots[name].set(value)
            elif name not in self._declared:
                raise ShaderError(f"{self._source.name}: no uniform is called {name}")

    def run(self, groups: int) -> None:
        """Run so many groups, and have all that comes later see what they wrote."""
        rows = -(-groups // _MOST_GROUPS)
        self._linked.run(min(groups, _MOST_GROUPS), rows)
        self._gl.memory_barrier()
