"""How the numbers of each AOV become colours: on a screen and in a file."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ssdo_gl.color import linear_from_srgb, srgb_from_linear

# Tells the farthest surface from the background.
FAINTEST = 0.1


class ColorMapping(IntEnum):
    """How an image turns into colours; the numbers are KIND in ``window/present.frag``.

    DISPLAY is sRGB-encoded already; RADIANCE is clipped at 1; VISIBILITY and ALBEDO are
    shown as they are. NORMAL maps [-1, 1] to [0, 1]; POSITION and DEPTH are stretched
    over a range (near = bright). These three are data and are not sRGB-encoded.
    """

    DISPLAY = 0
    RADIANCE = 1
    VISIBILITY = 2
    ALBEDO = 3
    NORMAL = 4
    POSITION = 5
    DEPTH = 6


# The beauty is shown by the tone mapper's ``display``; whatever is not here is a radiance.
COLOR_MAPPINGS: Mapping[str, ColorMapping] = {
    "beauty": ColorMapping.DISPLAY,
    "display": ColorMapping.DISPLAY,
    "visibility": ColorMapping.VISIBILITY,
    "albedo": ColorMapping.ALBEDO,
    "normal_ws": ColorMapping.NORMAL,
    "position_ws": ColorMapping.POSITION,
    "depth": ColorMapping.DEPTH,
}


def color_mapping(aov: str) -> ColorMapping:
    """Return how the picture of an AOV is made."""
    return COLOR_MAPPINGS.get(aov, ColorMapping.RADIANCE)


def picture_of(
    name: str,
    image: NDArray[np.float32],
    extent: tuple[ArrayLike, ArrayLike] | None = None,
) -> NDArray[np.uint8]:
    """Return an 8-bit RGB picture of an image, as `ColorMapping` says and the window shows.

    RGBA, straight, of a ``display`` that is not opaque.

    Parameters
    ----------
    name : str
        AOV, or ``display``.
    extent : (array_like, array_like) or None
        Values between which depth and position are spread: near and far, or the corners
        of the scene. None: what the image holds.
    """
    values = np.nan_to_num(image.astype(np.float64), nan=0.0, posinf=1e30, neginf=-1e30)
    mapping = color_mapping(name)
    if mapping is ColorMapping.NORMAL:
        covered = np.any(values != 0.0, axis=2, keepdims=True)
        return _to_bytes(np.where(covered, 0.5 + 0.5 * values, 0.0))
    if mapping in (ColorMapping.DEPTH, ColorMapping.POSITION):
        return _to_bytes(_stretched(values, extent, invert=mapping is ColorMapping.DEPTH))
    if name != "display":
        values = srgb_from_linear(np.clip(values[:, :, :3], 0.0, 1.0))
    pixels = _to_bytes(values[:, :, :3], dithered=True)
    if name == "display" and values.shape[2] == 4 and values[:, :, 3].min() < 1.0:
        return np.concatenate([pixels, _to_bytes(values[:, :, 3:])[:, :, :1]], axis=2)
    return pixels


def displayed(
    beauty: NDArray[np.float32], exposure: float, *, filmic: bool = False, cut_out: bool = False
) -> NDArray[np.float32]:
    """Return the ``display`` of a beauty, (height, width, 4), as ``lib/displayed.glsl`` has it.

    Of averaged frames it is lighter where some of them are clipped, which a device averages.

    Parameters
    ----------
    beauty : ndarray, shape (height, width, 4)
        Scene-linear, in front of its background; the fourth channel is coverage.
    exposure : float
        EV.
    filmic : bool
        Whether highlights roll off, as the curve ``aces`` has them, or are clipped at 1.
    cut_out : bool
        Whether the picture is transparent where nothing is covered.
    """
    light = beauty[:, :, :3].astype(np.float64)
    alpha = beauty[:, :, 3:] if cut_out else np.ones_like(beauty[:, :, 3:])
    if cut_out:
        light = np.divide(light, alpha, out=np.zeros_like(light), where=alpha > 0.0)
    x = np.nan_to_num(np.clip(light * 2.0**exposure, 0.0, 1e9))
    if filmic:
        x = 0.6 * x
        x = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
    encoded = srgb_from_linear(np.minimum(x, 1.0))
    return np.concatenate([encoded, alpha], axis=2).astype(np.float32)


def on_white(display: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return a ``display`` in front of white, opaque: (height, width, 3), sRGB-encoded.

    Light is mixed, not codes, so that edges look as they do over a white page.
    """
    alpha = display[:, :, 3:]
    mixed = alpha * linear_from_srgb(display[:, :, :3]) + (1.0 - alpha)
    return np.asarray(srgb_from_linear(mixed), np.float32)


def _stretched(
    values: NDArray[np.float64], extent: tuple[ArrayLike, ArrayLike] | None, *, invert: bool
) -> NDArray[np.float64]:
    covered = np.any(values != 0.0, axis=2)
    if not covered.any():
        return np.zeros_like(values)
    if extent is None:
        extent = values[covered].min(axis=0), values[covered].max(axis=0)
    low, high = (np.asarray(end, np.float64) for end in extent)
    span = np.where(high > low, high - low, 1.0)
    unit = np.clip((values - low) / span, 0.0, 1.0)
    unit = FAINTEST + (1.0 - FAINTEST) * (1.0 - unit if invert else unit)
    return np.where(covered[:, :, None], unit, 0.0)


def dither_pattern(height: int, width: int) -> NDArray[np.float64]:
    """Return what is added before rounding to whole steps, (height, width), in (-0.5, 0.5).

    Without it a gradient shows the steps of its eight bits. The fractions of the R2 sequence
    (Roberts 2018) along both axes: neighbours differ much, larger patches have a mean of 0,
    and the pattern is the same in every picture.
    """
    row, column = np.ogrid[:height, :width]
    return np.asarray((0.5 + 0.7548776662466927 * column + 0.5698402909980532 * row) % 1.0 - 0.5)


def _to_bytes(unit: NDArray[np.float64], *, dithered: bool = False) -> NDArray[np.uint8]:
    steps = 255.0 * np.clip(unit, 0.0, 1.0)
    if dithered:
        steps = np.clip(steps + dither_pattern(*steps.shape[:2])[:, :, None], 0.0, 255.0)
    pixels = np.round(steps).astype(np.uint8)
    return np.repeat(pixels, 3, axis=2) if pixels.shape[2] == 1 else pixels
