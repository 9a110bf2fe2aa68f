"""A copy of the images of the last frame, to be read while the next is in the making."""

from __future__ import annotations

import dataclasses

import moderngl

from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.texture import drawing_into, make_texture
from ssdo_gl.render_result import Drawing, Plane


class KeptPlanes:
    """Keeps the images of one frame.

    Attributes
    ----------
    drawing : Drawing or None
        What `keep` was given last, with textures of its own.
    """

    def __init__(self, device: Device) -> None:
        self.drawing: Drawing | None = None
        self._gl = device.gl
        self._textures: list[moderngl.Texture] = []

    def keep(self, drawing: Drawing) -> None:
        """Copy all images of `drawing`, in place of those before."""
        self.release()
        copies: dict[int, moderngl.Texture] = {}
        planes: dict[str, Plane] = {}
        for name, plane in drawing.planes.items():
            texture = plane.texture
            if texture is not None and texture.glo not in copies:
                copies[texture.glo] = self._copy(texture)
            own = None if texture is None else copies[texture.glo]
            planes[name] = dataclasses.replace(plane, texture=own)
        self._textures = list(copies.values())
        self.drawing = dataclasses.replace(drawing, planes=planes)

    def release(self) -> None:
        """Free the copies."""
        for texture in self._textures:
            texture.release()
        self._textures = []
        self.drawing = None

    def _copy(self, texture: moderngl.Texture) -> moderngl.Texture:
        copy = make_texture(self._gl, texture.size, texture.components, texture.dtype)
        with drawing_into(self._gl, texture) as source, drawing_into(self._gl, copy) as target:
            self._gl.copy_framebuffer(target, source)
        return copy
