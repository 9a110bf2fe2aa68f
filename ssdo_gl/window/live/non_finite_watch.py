"""Watches for values that are not finite."""

from __future__ import annotations

from dataclasses import dataclass

import moderngl
import numpy as np

from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.gpu.texture import make_framebuffer, make_texture, read_texture

# Texels summed up by one thread of the alarm: few enough results to read back at once.
_BLOCK = 16


@dataclass(frozen=True)
class Alarm:
    """Values that are not finite, in an image.

    Attributes
    ----------
    count : int
        Pixels that hold a NaN or an infinity.
    pixel : (int, int)
        The corner of a block that has some; column and row, row 0 at the top.
    """

    count: int
    pixel: tuple[int, int]


class NonFiniteWatch:
    """Counts the pixels of an image that hold a NaN or an infinity."""

    def __init__(self, device: Device, shaders: ShaderLibrary) -> None:
        self._gl = device.gl
        self._shaders = shaders
        self._target: moderngl.Framebuffer | None = None
        self._counts: moderngl.Texture | None = None

    def check(self, texture: moderngl.Texture) -> Alarm | None:
        """Return what is wrong with `texture`; None if all of it is finite."""
        size = -(-texture.width // _BLOCK), -(-texture.height // _BLOCK)
        if self._target is None or self._target.size != size:
            self.release()
            self._counts = make_texture(self._gl, size, 1, "f4")
            self._target = make_framebuffer(self._gl, [self._counts])
        assert self._counts is not None
        program = self._shaders.fullscreen("window/count_non_finite.frag", {"BLOCK": _BLOCK})
        draw_fullscreen(self._gl, program, self._target, {}, {"t_image": texture})
        counts = read_texture(self._counts)[:, :, 0]
        total = int(counts.sum())
        if total == 0:
            return None
        row, column = np.unravel_index(int(counts.argmax()), counts.shape)
        # Blocks start at the bottom; the topmost one may stick out of the image.
        bottom = (size[1] - 1 - int(row)) * _BLOCK
        top = texture.height - min(bottom + _BLOCK, texture.height)
        return Alarm(total, (int(column) * _BLOCK, top))

    def release(self) -> None:
        """Free the device objects."""
        for item in (self._target, self._counts):
            if item is not None:
                item.release()
        self._target = self._counts = None
