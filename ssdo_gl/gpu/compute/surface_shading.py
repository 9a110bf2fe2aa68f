"""Runs a compute shader of `visible_surface_source`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import moderngl

from ssdo_gl.gpu.compute.compute_program import ComputeProgram
from ssdo_gl.gpu.compute.visible_surface import (
    CLEARS,
    IDS,
    INDICES,
    INSTANCES,
    PIXELS,
    STREAMS,
    TRIANGLES,
)


def shade_triangles(
    gl: moderngl.Context,
    program: ComputeProgram,
    ids: moderngl.Texture,
    outputs: Sequence[moderngl.Texture],
    mesh: tuple[moderngl.Buffer, Mapping[str, moderngl.Buffer]],
    instances: moderngl.Buffer,
    numbers: tuple[int, int, int],
    *,
    clears: bool,
) -> None:
    """Write the surfaces of these triangles where they show.

    Parameters
    ----------
    ids : moderngl.Texture
        Complements of triangles' numbers, 0 where none shows.
    mesh : (indices, vertex streams by name)
    numbers : (int, int, int)
        Of the first triangle; how many there are, and how many to an instance.
    clears : bool
        Write 0 where no triangle shows.
    """
    program.number(TRIANGLES, numbers)
    program.number(CLEARS, int(clears))
    program.number(IDS, program.first_unit)
    ids.use(program.first_unit)
    mesh[0].bind_to_storage_buffer(INDICES)
    instances.bind_to_storage_buffer(INSTANCES)
    for name, buffer in mesh[1].items():
        buffer.bind_to_storage_buffer(STREAMS[name])
    program.run(gl, outputs, (0, 0, *ids.size), adds=False, pixels=PIXELS)
