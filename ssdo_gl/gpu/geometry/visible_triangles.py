"""Draws the surfaces of the triangles that show, found by a `TriangleRasterizer`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import moderngl

from ssdo_gl.gpu.compute import shade_triangles
from ssdo_gl.gpu.geometry.device_geometry import Numbered
from ssdo_gl.gpu.program import Program


def draw_surfaces(
    gl: moderngl.Context,
    ids: moderngl.Texture,
    parts: Sequence[Numbered],
    programs: Sequence[Program],
    outputs: Sequence[moderngl.Texture],
    uniforms: Mapping[str, object],
) -> None:
    """Write what shows of `parts`, which are all that has a number, and 0 where nothing does.

    Parameters
    ----------
    ids : moderngl.Texture
        Of `TriangleRasterizer`.
    programs : sequence of Program
        Of `ShaderLibrary.visible_surface`, for what each part needs; compute shaders.
    uniforms : mapping
        Of each of them.
    """
    for part, program in zip(parts, programs, strict=True):
        group = part.group
        own: Mapping[str, Any] = part.batch.material or {}
        textures = {n: t for n, t in group.textures.items() if program.takes(n)}
        program.set({**uniforms, **{n: v for n, v in own.items() if program.takes(n)}}, textures)
        program.check_complete(textures)
        instances, count = part.visible.in_turn, group.vertices.triangle_count
        group.hold(instances)
        assert program.compute is not None
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
