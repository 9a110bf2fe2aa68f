"""Images of materials on the device: uploaded once, mip-mapped, sRGB decoded."""

from __future__ import annotations

from collections.abc import Iterable

import moderngl
import numpy as np

from ssdo_gl.scene.material import Material, Texture

# moderngl names no sRGB format but takes the number of one. The hardware then
# decodes before it filters, which decoding in the shader could not.
GL_SRGB8_ALPHA8 = 0x8C43


class MaterialTextures:
    """Device copies of scene textures, by identity of the scene's `Texture`."""

    def __init__(self, gl: moderngl.Context) -> None:
        self._gl = gl
        # The scene texture is kept with its copy so that its id stays taken.
        self._known: dict[int, tuple[Texture, moderngl.Texture]] = {}

    def get(self, texture: Texture) -> moderngl.Texture:
        """Return the device copy of `texture`; row 0 of the image is at v = 0."""
        if id(texture) not in self._known:
            self._known[id(texture)] = (texture, self._upload(texture))
        return self._known[id(texture)][1]

    def keep(self, materials: Iterable[Material]) -> None:
        """Free the copies that none of `materials` uses."""
        used = {id(t) for m in materials for t in (m.albedo_texture, m.emission_texture)}
        for key in [key for key in self._known if key not in used]:
            self._known.pop(key)[1].release()

    def _upload(self, texture: Texture) -> moderngl.Texture:
        height, width, _ = texture.pixels.shape
        data = np.ascontiguousarray(texture.pixels)
        if data.dtype == np.uint8:
            copy = self._gl.texture(
                (width, height), 4, data.tobytes(), dtype="f1", internal_format=GL_SRGB8_ALPHA8
            )
        else:
            copy = self._gl.texture((width, height), 4, data.tobytes(), dtype="f4")
        copy.build_mipmaps()
        magnified = moderngl.NEAREST if texture.nearest else moderngl.LINEAR
        copy.filter = (moderngl.LINEAR_MIPMAP_LINEAR, magnified)
        copy.repeat_x, copy.repeat_y = (wrap == "repeat" for wrap in texture.wrap)
        return copy
