"""The colour space sRGB (IEC 61966-2-1): luminance, from CIE XYZ, the transfer function."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

# Of scene-linear Rec.709.
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
# From CIE XYZ to scene-linear Rec.709 with its white, D65.
RGB_FROM_XYZ = np.array(
    [
        [3.2404542, -1.5371385, -0.4985314],
        [-0.9692660, 1.8760108, 0.0415560],
        [0.0556434, -0.2040259, 1.0572252],
    ]
)
_Floats = NDArray[np.floating[Any]]


def srgb_from_linear(linear: _Floats) -> NDArray[np.float64]:
    """Return sRGB-encoded values of scene-linear ones, both in [0, 1]."""
    # The floor keeps the power of the branch that is not taken defined at zero.
    curved = 1.055 * np.maximum(linear, 1e-12) ** (1 / 2.4) - 0.055
    return np.where(linear <= 0.0031308, 12.92 * linear, curved).astype(np.float64)


def linear_from_srgb(encoded: _Floats) -> NDArray[np.float64]:
    """Return scene-linear values of sRGB-encoded ones, both in [0, 1]."""
    curved = ((encoded + 0.055) / 1.055) ** 2.4
    return np.where(encoded <= 0.04045, encoded / 12.92, curved).astype(np.float64)
