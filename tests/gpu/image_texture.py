"""Textures of images, for passes that read them."""

from __future__ import annotations

import moderngl
import numpy as np
from numpy.typing import ArrayLike

from ssdo_gl.gpu.texture import make_texture


def texture_from_image(
    gl: moderngl.Context, image: ArrayLike, dtype: str = "f4"
) -> moderngl.Texture:
    """Return a texture of `image` (height, width, channels), row 0 at the **top**.

    The inverse of `read_texture`; (height, width) is one channel.
    """
    array = np.asarray(image)
    array = array[..., None] if array.ndim == 2 else array
    height, width, components = array.shape
    return make_texture(gl, (width, height), components, dtype, array[::-1])
