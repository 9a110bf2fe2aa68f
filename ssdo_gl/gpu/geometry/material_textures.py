"""Images of materials on the device: uploaded once, mip-mapped, sRGB decoded."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ssdo_gl.gpu.texture import image_texture
from ssdo_gl.scene.material import Material, Texture


class MaterialTextures:
    """Device copies of scene textures, by identity of the scene's `Texture`."""

    def __init__(self, gl: moderngl.Context) -> None:
        self._gl = gl
        # The scene texture is kept with its copy so that its id stays taken.
        self._known: dict[tuple[int, float | None, bool], tuple[Texture, moderngl.Texture]] = {}

    def get(
        self, texture: Texture, cutoff: float | None = None, *, is_normals: bool = False
    ) -> moderngl.Texture:
        """Return the device copy of `texture`; row 0 of the image is at v = 0.

        Parameters
        ----------
        cutoff : float or None
            What is less opaque is cut out: mip maps then keep the share that is left.
        is_normals : bool
            Whether alpha is to hold how far the normals of a texel lean: `keep_spread`.
        """
        key = id(texture), cutoff, is_normals
        if key not in self._known:
            copy = self._upload(texture, is_normals)
            if cutoff is not None:
                keep_coverage(copy, cutoff)
            if is_normals:
                keep_spread(copy, texture.pixels)
            self._known[key] = (texture, copy)
        return self._known[key][1]

    def keep(self, materials: Iterable[Material]) -> None:
        """Free the copies that none of `materials` uses."""
        used = {id(texture) for m in materials for texture in m.textures.values()}
        for key in [key for key in self._known if key[0] not in used]:
            self._known.pop(key)[1].release()

    def _upload(self, texture: Texture, is_normals: bool) -> moderngl.Texture:
        pixels = texture.pixels
        if is_normals:
            pixels = pixels * np.array([1, 1, 1, 0], pixels.dtype)
        copy = image_texture(self._gl, pixels, is_data=texture.is_data)
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


def keep_spread(texture: moderngl.Texture, pixels: NDArray[Any]) -> None:
    """Make alpha of mip levels the width of GGX that the normals under a texel spread over.

    Their mean, of length r, is that of a von Mises-Fisher distribution of concentration
    r (3 - r^2) / (1 - r^2), as narrow as GGX where alpha^2 is twice the inverse of that
    (Toksvig 2005, "Mipmapping Normal Maps"; Banerjee et al. 2005). Means are taken of unit
    normals: those of 8 bits alone are as short as a roughness of 0.26 makes them.
    """
    full = 255.0 if pixels.dtype == np.uint8 else 1.0
    # In bands of rows, which stay in the processor's cache.
    ends = range(0, max(len(pixels) // 2 * 2, 1), 64)
    n = np.concatenate([_halved(_unit_normals(pixels[i : i + 64], full)) for i in ends])
    for level in range(1, max(texture.size).bit_length()):
        n = _halved(n) if level > 1 else n
        r_2 = np.minimum(np.einsum("ijk,ijk->ij", n, n), 1.0)
        spread = np.sqrt(2.0 * (1.0 - r_2) / np.maximum(np.sqrt(r_2) * (3.0 - r_2), 1e-6))
        data = np.frombuffer(texture.read(level=level), pixels.dtype)
        data = data.reshape(*n.shape[:2], 4).copy()
        data[..., 3] = full * np.minimum(spread, 1.0)
        texture.write(data.tobytes(), level=level)


def _unit_normals(pixels: NDArray[Any], full: float) -> NDArray[np.float32]:
    n = pixels[..., :3].astype(np.float32) * np.float32(2.0 / full) - np.float32(1.0)
    size_2 = np.einsum("ijk,ijk->ij", n, n)
    # As in lib/bump.glsl: no direction is an even surface.
    is_even = ~(size_2 > 1e-4)
    n[is_even], size_2[is_even] = (0.0, 0.0, 1.0), 1.0
    return np.asarray(n / np.sqrt(size_2)[..., None])


def _halved(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return means of 2 x 2 texels, as mip maps have them; what is left over is left out."""
    for axis in range(2):
        rows = image.swapaxes(0, axis)
        count = len(rows) // 2
        rows = 0.5 * (rows[: 2 * count : 2] + rows[1 : 2 * count : 2]) if count else rows
        image = rows.swapaxes(0, axis)
    return image


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
