"""Images of materials on the device: uploaded once, mip-mapped, sRGB decoded."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ssdo_gl.scene.material import Material, Texture

# moderngl names no sRGB format but takes the number of one. The hardware then
# decodes before it filters, which decoding in the shader could not.
GL_SRGB8_ALPHA8 = 0x8C43


class MaterialTextures:
    """Device copies of scene textures, by identity of the scene's `Texture`."""

    def __init__(self, gl: moderngl.Context) -> None:
        self._gl = gl
        # The scene texture is kept with its copy so that its id stays taken.
        self._known: dict[tuple[int, float | None], tuple[Texture, moderngl.Texture]] = {}

    def get(self, texture: Texture, cutoff: float | None = None) -> moderngl.Texture:
        """Return the device copy of `texture`; row 0 of the image is at v = 0.

        Parameters
        ----------
        cutoff : float or None
            What is less opaque is cut out: mip maps then keep the share that is left.
        """
        key = id(texture), cutoff
        if key not in self._known:
            copy = self._upload(texture)
            if cutoff is not None:
                keep_coverage(copy, cutoff)
            self._known[key] = (texture, copy)
        return self._known[key][1]

    def keep(self, materials: Iterable[Material]) -> None:
        """Free the copies that none of `materials` uses."""
        used = {id(texture) for m in materials for texture in m.textures.values()}
        for key in [key for key in self._known if key[0] not in used]:
            self._known.pop(key)[1].release()

    def _upload(self, texture: Texture) -> moderngl.Texture:
        height, width, _ = texture.pixels.shape
        data = np.ascontiguousarray(texture.pixels)
        if texture.is_data and data.dtype == np.uint8:
            copy = self._gl.texture((width, height), 4, data.tobytes(), dtype="f1")
        elif data.dtype == np.uint8:
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


def keep_coverage(texture: moderngl.Texture, cutoff: float) -> None:
    """Make every mip level as opaque as the image itself is, measured against `cutoff`.

    Averaged alpha falls below the cutoff where a fence is thinner than a texel, and the
    fence dissolves with distance (I. Castano, "Computing Alpha Mipmaps", 2010). Where
    texels of a level are alike, some of them are chosen.
    """
    dtype: type[Any] = np.uint8 if texture.dtype == "f1" else np.float32
    full = 255.0 if dtype is np.uint8 else 1.0
    first = np.frombuffer(texture.read(), dtype).reshape(-1, 4)
    share = float(np.mean(first[:, 3] >= cutoff * full))
    if share in (0.0, 1.0):
        return
    level, size = 0, max(texture.size)
    while size > 1:
        level, size = level + 1, size // 2
        pixels = np.frombuffer(texture.read(level=level), dtype).reshape(-1, 4).copy()
        texture.write(_with_coverage(pixels, share, cutoff * full, full).tobytes(), level=level)


def _with_coverage(pixels: NDArray[Any], share: float, cutoff: float, full: float) -> NDArray[Any]:
    alpha = pixels[:, 3].astype(np.float64)
    # The golden ratio spreads the choice among texels that are alike.
    order = np.argsort(-alpha - np.arange(len(alpha)) * 0.618033988749895 % 1.0 * full / 512.0)
    count = round(share * len(alpha))
    # As far above the cutoff as below it, so that interpolation crosses it half way.
    contrast = min(cutoff, full - cutoff)
    alpha[order[:count]] = cutoff + contrast
    alpha[order[count:]] = cutoff - contrast
    pixels[:, 3] = np.clip(alpha, 0.0, full).astype(pixels.dtype)
    return pixels
