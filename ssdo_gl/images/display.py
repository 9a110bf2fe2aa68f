"""Turns any AOV into an 8-bit picture a person can look at."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.images.color import srgb_from_linear


def picture_of(name: str, image: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return an 8-bit RGB picture of the AOV `name`.

    Normals map [-1, 1] to [0, 1]; depth and position are stretched over what the
    image holds (near = bright); visibility is shown as it is (1 = white); radiance is
    clipped at 1; ``display`` is sRGB-encoded already. Normals, positions and depth are
    data and are not sRGB-encoded.
    """
    values = np.nan_to_num(image.astype(np.float64), nan=0.0, posinf=1e30, neginf=-1e30)
    if name == "normal_ws":
        covered = np.any(values != 0.0, axis=2, keepdims=True)
        return _to_bytes(np.where(covered, 0.5 + 0.5 * values, 0.0))
    if name in ("depth", "position_ws"):
        return _to_bytes(_stretched(values, invert=name == "depth"))
    if name == "display":
        return _to_bytes(values[:, :, :3])
    return _to_bytes(srgb_from_linear(np.clip(values[:, :, :3], 0.0, 1.0)))


def _stretched(values: NDArray[np.float64], *, invert: bool) -> NDArray[np.float64]:
    covered = np.any(values != 0.0, axis=2)
    if not covered.any():
        return np.zeros_like(values)
    low, high = values[covered].min(axis=0), values[covered].max(axis=0)
    span = np.where(high > low, high - low, 1.0)
    unit = (values - low) / span
    # A floor of 0.1 tells the farthest surface from the background.
    unit = 0.1 + 0.9 * (1.0 - unit if invert else unit)
    return np.where(covered[:, :, None], unit, 0.0)


def _to_bytes(unit: NDArray[np.float64]) -> NDArray[np.uint8]:
    pixels = np.round(255.0 * np.clip(unit, 0.0, 1.0)).astype(np.uint8)
    return np.repeat(pixels, 3, axis=2) if pixels.shape[2] == 1 else pixels
