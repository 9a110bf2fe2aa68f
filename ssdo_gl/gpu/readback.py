"""From a texture to a NumPy array: the only place that flips rows."""

from __future__ import annotations

import moderngl
import numpy as np
from numpy.typing import NDArray

from ssdo_gl.gpu import texture as texture_module


def read_texture(texture: moderngl.Texture) -> NDArray[np.float32]:
    """Return the texture as float32, shape (height, width, channels), row 0 at the top.

    Normalised integers come back in [0, 1]. Waits until the texture is drawn.
    """
    shape = (texture.height, texture.width, texture.components)
    rows = texture_module.unpack(texture.read(alignment=1), shape, texture.dtype)
    return np.ascontiguousarray(rows[::-1], dtype=np.float32)
