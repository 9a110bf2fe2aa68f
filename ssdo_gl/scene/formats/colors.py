"""Vertex and face colours as files write them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.color import linear_from_srgb
from ssdo_gl.math3d import FloatArray


def linear_colors(encoded: NDArray[Any], kind: np.dtype[Any] | None = None) -> FloatArray:
    """Return (N, 4) scene-linear colour and alpha of sRGB-encoded (N, 3) or (N, 4).

    Integers of one byte or of unknown width reach from 0 to 255 and those of two bytes
    to 65535, unless none exceeds 255. Floats reach to 1, or to 255 if any exceeds 1.

    Parameters
    ----------
    kind : dtype or None
        The file's own type; None: that of `encoded`.
    """
    kind = encoded.dtype if kind is None else kind
    values = np.nan_to_num(encoded.astype(np.float64), nan=0.0, posinf=0.0, neginf=0.0)
    largest = values.max(initial=0.0)
    if kind.kind == "f":
        scale = 255.0 if largest > 1.0 else 1.0
    else:
        scale = 65535.0 if kind.itemsize == 2 and largest > 255.0 else 255.0
    values = np.clip(values / scale, 0.0, 1.0)
    alpha = values[:, 3:4] if values.shape[1] > 3 else np.ones((len(values), 1))
    return np.concatenate([linear_from_srgb(values[:, :3]), alpha], axis=1)
