"""Clears framebuffers, colour to zero, depth to the far end; or keeps a part from draws."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import moderngl

from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.math3d import Region


def clear(gl: moderngl.Context, shaders: ShaderLibrary, target: moderngl.Framebuffer) -> None:
    """Set every channel of `target` to 0 and its depth to 1, the fastest way of the device.

    A rasterizer of few units also clears slowly: at 3840x2160 the textures of a frame take an
    NVIDIA H100 9 ms.
    """
    program = shaders.fullscreen("passes/clear.frag") if shaders.computes else None
    if program is None or program.compute is None:
        target.clear()
        return
    textures: Any = target.color_attachments
    for texture in textures:
        program.compute.run(gl, [texture], (0, 0, *texture.size), adds=False)
    if target.depth_attachment is not None:
        # Any: the stubs know of one mask for each attachment only where there is one.
        depth_only: Any = target
        mask, hidden = depth_only.color_mask, (False, False, False, False)
        depth_only.color_mask = hidden if len(textures) == 1 else (hidden,) * len(textures)
        target.clear()
        depth_only.color_mask = mask
        # Of a single attachment OpenGL only learns the mask when it is bound.
        target.use()


def clear_last_in(target: moderngl.Framebuffer, region: Region) -> None:
    """Do so in software, but with the last of several attachments only in a part.

    One of four floats takes it as long as all others of the G-buffer.
    """
    masks: Any = target.color_mask
    hidden = (False,) * 4
    target.color_mask = (*masks[:-1], hidden)
    target.clear()
    target.color_mask = (*(hidden,) * (len(masks) - 1), masks[-1])
    target.depth_mask = False
    target.clear(viewport=region)
    target.color_mask, target.depth_mask = masks, True
    target.use()


@contextmanager
def last_kept(target: moderngl.Framebuffer) -> Iterator[None]:
    """Leave the last of several attachments as it is while inside."""
    masks = target.color_mask
    assert isinstance(masks[0], tuple), "a single attachment is what the draw is for"
    target.color_mask = (*masks[:-1], (False,) * 4)
    try:
        yield
    finally:
        target.color_mask = masks
