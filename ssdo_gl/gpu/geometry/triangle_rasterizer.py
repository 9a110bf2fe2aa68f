"""Rasterizes a scene's triangles by compute shaders, where few processors draw.

Small triangles are drawn by one invocation each, large ones block by block; the nearest of each
pixel is found by atomic operations: first its depth, then, in a second run, which triangle has it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import moderngl

from ssdo_gl.gpu.compute import Kernel
from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.geometry.device_geometry import Numbered
from ssdo_gl.gpu.instance_attributes import INSTANCE_FLOATS
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.gpu.texture import make_framebuffer, make_texture

# Bindings, and the room for large triangles, as in shaders/rasterizer.
_RECORDS, _BLOCKS, _INDICES, _INSTANCES, _POSITIONS = 2, 3, 4, 5, 6
_HEAD_BYTES, _RECORD_BYTES, _BLOCK_BYTES = 16, 80, 8
# Pixels for each large triangle, and each block, that there is room for: 587,000 triangles need
# an eighth of it. Without room a triangle is drawn by one invocation: a wall takes 300 ms.
_PIXELS_PER_RECORD, _PIXELS_PER_BLOCK, _LEAST_RECORDS = 32, 4, 1 << 12
_INVOCATIONS = 64
# Groups that share all blocks: some for each of a large device's 132 processors.
_BLOCK_GROUPS = 2048
_NONE = (1 << 32) - 1
# Each batch takes some 5 us of a device that waits for all of it to end, and of the host.
MOST_BATCHES = 64


def can_rasterize(parts: Sequence[Numbered]) -> bool:
    """Return whether a `TriangleRasterizer` can draw `parts`, and not in too many steps.

    Holes are looked up in images, which are another batch's for the next pixel.
    """
    return 0 < len(parts) <= MOST_BATCHES and not any(p.features.alpha_cutout for p in parts)


class TriangleRasterizer:
    """What is nearest in each pixel of a frame.

    Attributes
    ----------
    depth_keys, ids : moderngl.Texture
        Complements of depths along the view axis, as bits, and of triangles' numbers; 0 is
        background.
    """

    def __init__(
        self,
        gl: moderngl.Context,
        size: tuple[int, int],
        *,
        ids: bool,
        room: tuple[int, int] | None = None,
    ) -> None:
        self._gl = gl
        self.size = size
        self.depth_keys = make_texture(gl, size, 1, "u4")
        self.ids = make_texture(gl, size, 1, "u4") if ids else self.depth_keys
        self._textures = [self.depth_keys, *([self.ids] if ids else [])]
        self._targets = [make_framebuffer(gl, [item]) for item in self._textures]
        pixels = size[0] * size[1]
        records = max(pixels // _PIXELS_PER_RECORD, _LEAST_RECORDS)
        self._room = room = room or (records, records * _PIXELS_PER_RECORD // _PIXELS_PER_BLOCK)
        self._records = gl.buffer(reserve=_HEAD_BYTES + _RECORD_BYTES * room[0])
        self._blocks = gl.buffer(reserve=_BLOCK_BYTES * room[1])

    def draw(
        self,
        shaders: ShaderLibrary,
        parts: Sequence[Numbered],
        uniforms: Mapping[str, object],
        *,
        backs: bool = False,
    ) -> None:
        """Draw these triangles.

        Parameters
        ----------
        uniforms : mapping
            Of ``rasterizer/triangle.glsl``.
        backs : bool
            Draw back faces only; else what does not hide behind a solid's own front.
        """
        clear = shaders.fullscreen("passes/clear_ids.frag")
        for target in self._targets:
            draw_fullscreen(self._gl, clear, target, {}, {})
        self._records.write(bytes(16))
        triangles = shaders.kernel("rasterizer/draw_triangles.comp")
        blocks = shaders.kernel("rasterizer/draw_blocks.comp")
        for item in (triangles, blocks):
            item.set({**uniforms, "u_room": self._room})
        self.depth_keys.bind_to_image(0, read=True, write=True)
        self.ids.bind_to_image(1, read=True, write=True)
        self._records.bind_to_storage_buffer(_RECORDS)
        self._blocks.bind_to_storage_buffer(_BLOCKS)
        for step in range(len(self._textures)):
            for part in parts:
                self._draw_part(triangles, part, step, backs)
            blocks.set({"u_gives_ids": step})
            blocks.run(_BLOCK_GROUPS)

    @staticmethod
    def _draw_part(kernel: Kernel, part: Numbered, step: int, backs: bool) -> None:
        group, count = part.group, part.group.vertices.triangle_count
        instances = part.visible.in_turn
        group.hold(instances)
        if part.features.single_sided:
            fronts = 0
        else:
            fronts = len(part.visible.around) if group.is_solid else _NONE
        kernel.set(
            {
                "u_gives_ids": step,
                "u_triangles": (part.first, count * len(instances), count),
                "u_instance_floats": INSTANCE_FLOATS,
                "u_first_of_fronts": fronts,
                "u_shows_backs": int(backs),
                "u_is_mirrored": int(part.is_mirrored),
            }
        )
        group.vertices.indices.bind_to_storage_buffer(_INDICES)
        group.instances.bind_to_storage_buffer(_INSTANCES)
        group.vertices.buffers["a_position_os"][0].bind_to_storage_buffer(_POSITIONS)
        kernel.run(-(-count * len(instances) // _INVOCATIONS))
