"""Draws the surfaces of the triangles that show, found by a `TriangleRasterizer`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import moderngl

from ssdo_gl.gpu.compute import shade_triangles
from ssdo_gl.gpu.device_geometry import Numbered
from ssdo_gl.gpu.draw_group import Features
from ssdo_gl.gpu.shader import Program

ProgramOf = Callable[[Features], Program]


def draw_surfaces(
    gl: moderngl.Context,
    ids: moderngl.Texture,
    parts: Sequence[Numbered],
    outputs: Sequence[moderngl.Texture],
    program_of: ProgramOf,
    uniforms: Mapping[str, object],
) -> None:
    """Write what shows of `parts`, which are all that has a number, and 0 where nothing does.

    Parameters
    ----------
    ids : moderngl.Texture
        Of `TriangleRasterizer`.
    program_of : callable
        Returns the program of `ShaderLibrary.visible_surface` for what a group of objects needs.
    uniforms : mapping
        Of each of them.
    """
    for part in parts:
        program, group = program_of(part.features), part.group
        own: Mapping[str, Any] = part.batch.material or {}
        textures = {n: t for n, t in group.textures.items() if program.takes(n)}
        program.set({**uniforms, **{n: v for n, v in own.items() if program.takes(n)}}, textures)
        program.check_complete(textures)
        instances, count = part.visible.in_turn, group.vertices.triangle_count
        group.hold(instances)
        assert program.compute is not None, "it is asked before whether the driver links it"
        streams = {name: buffer for name, (buffer, _) in group.vertices.buffers.items()}
        shade_triangles(
            gl,
            program.compute,
            ids,
            outputs,
            (group.vertices.indices, streams),
            group.instances,
            (part.first, count * len(instances), count),
            clears=part is parts[0],
        )
