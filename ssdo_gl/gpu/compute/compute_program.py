"""Runs a full-screen shader as a compute shader, and says where that is the faster way."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any

import moderngl

from ssdo_gl.gpu.compute.translation import (
    ADDS,
    DERIVATIVES_EXTENSION,
    GROUP_SIZE,
    ORIGIN,
    REGION,
    SIZE,
    needs_derivatives,
)
from ssdo_gl.gpu.shader_source import FlatSource

_INT2, _INT4, _FLOAT2, _INT = (struct.Struct(f"={n}") for n in ("2i", "4i", "2f", "i"))
_TARGET = "compute_target_"


def can_compute(gl: moderngl.Context, source: FlatSource) -> bool:
    """Whether the driver has what a compute shader needs."""
    if not needs_derivatives(source):
        return True
    return DERIVATIVES_EXTENSION in gl.extensions


class ComputeProgram:
    """A compute shader of `compute_source`, and what its made uniforms hold.

    Attributes
    ----------
    first_unit : int
        The first texture unit that none of the shader's own samplers takes.
    """

    def __init__(self, linked: moderngl.ComputeShader) -> None:
        self._linked = linked
        self.first_unit = 0
        members: Any = linked
        names = [name for name in members if name.startswith(_TARGET)]
        self._targets = {int(name.removeprefix(_TARGET)): members[name] for name in names}
        self._uniforms = {
            name: members[name] for name in (ORIGIN, REGION, SIZE, ADDS) if name in list(members)
        }
        self._placed: tuple[object, ...] = ()

    def number(self, name: str, value: object) -> None:
        """Give a made uniform a value."""
        member: Any = self._linked
        member[name].value = value

    def run(
        self,
        gl: moderngl.Context,
        outputs: Sequence[moderngl.Texture],
        region: tuple[int, int, int, int],
        *,
        adds: bool,
        pixels: int = 1,
    ) -> None:
        """Shade `region` (x, y, width, height) of `outputs`, all of one size.

        `adds`: to what they hold, instead of replacing it; `pixels`: of an invocation, along
        each side of what its group covers.
        """
        x, y, width, height = region
        # Quads begin at even pixels, as a rasterizer's do.
        left, bottom = x & ~1, y & ~1
        placed = region, outputs[0].size, adds
        if placed != self._placed:
            self._set(ORIGIN, _INT2.pack(left, bottom))
            self._set(REGION, _INT4.pack(x, y, x + width, y + height))
            self._set(SIZE, _FLOAT2.pack(*outputs[0].size))
            self._set(ADDS, _INT.pack(adds))
            self._placed = placed
        for n, texture in enumerate(outputs):
            texture.bind_to_image(n, read=False, write=True)
            if adds and n in self._targets:
                texture.use(self.first_unit + n)
                self._targets[n].value = self.first_unit + n
        columns = -(-(x + width - left) // (pixels * GROUP_SIZE[0]))
        rows = -(-(y + height - bottom) // (pixels * GROUP_SIZE[1]))
        self._linked.run(columns, rows)
        # Textures, framebuffers and read-back all come after it.
        gl.memory_barrier()

    def _set(self, name: str, data: bytes) -> None:
        if name in self._uniforms:
            self._uniforms[name].write(data)
