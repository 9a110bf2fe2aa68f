"""Draws the surfaces of the triangles that show, found by a `TriangleRasterizer`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import moderngl

from ssdo_gl.gpu.compute import CLEARS, IDS, INDICES, INSTANCES, PIXELS, STREAMS, TRIANGLES
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
        textures = {n: t for n, t in group.textures.items() if program.takes(n)}
        program.set(uniforms, textures)
        program.check_complete(textures)
        instances, count = part.visible.in_turn, group.vertices.triangle_count
        group.hold(instances)
        compute = program.compute
        assert compute is not None
        compute.number(TRIANGLES, (part.first, count * len(instances), count))
        compute.number(CLEARS, int(part is parts[0]))
        compute.number(IDS, compute.first_unit)
        ids.use(compute.first_unit)
        group.vertices.indices.bind_to_storage_buffer(INDICES)
        group.instances.bind_to_storage_buffer(INSTANCES)
        for name, (buffer, _) in group.vertices.buffers.items():
            buffer.bind_to_storage_buffer(STREAMS[name])
        compute.run(gl, outputs, (0, 0, *ids.size), adds=False, pixels=PIXELS)
