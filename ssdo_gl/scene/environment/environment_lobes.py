"""Distant light as glossy surfaces see it: blurred by the lobe of their reflection.

The lobe is that of GGX seen along the normal (the first factor of Karis 2013, "Real
Shading in Unreal Engine 4"): the same all around, so that it multiplies the spherical
harmonics of the light, of each degree by one number.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.environment.environment_kinds import Environment
from ssdo_gl.scene.environment.environment_light import cosine_edges, overlaps, radiance_image

# Level k is blurred by a lobe of width alpha = 2^(k - 6), and each level has half the texels
# of the one before along each side: a texel is 0.8 of the lobe's half width in all of them.
LEVEL_COUNT = 7
_FIRST_SIZE = 512, 256
# Degrees of the harmonics. The lobe of level 1, alpha = 1/32, has lost all but e^-8 there.
_DEGREES = 128


def lobe_levels(environment: Environment) -> list[NDArray[np.float32]]:
    """Return lat-long images (height, width, 4) of radiance, oriented as `radiance_image`.

    Level 0 is the environment itself, level k >= 1 the mean over the lobe of width
    alpha = 2^(k - 6) about each direction. The fourth channel is 1.
    """
    image = radiance_image(environment)
    image = np.concatenate([image, np.ones_like(image[..., :1])], axis=-1)
    levels = [_resized(image, _FIRST_SIZE[1], _FIRST_SIZE[0])]
    half = _resized(image, _FIRST_SIZE[1] // 2, _FIRST_SIZE[0] // 2)
    harmonics = _transformed(half)
    for level in range(1, LEVEL_COUNT):
        degrees = max(2 * _DEGREES >> level, 16)
        gains = lobe_gains(2.0 ** (level - LEVEL_COUNT + 1), degrees)
        found = _synthesised(
            harmonics[:degrees, :degrees] * gains[:, None, None],
            _FIRST_SIZE[1] >> level,
            _FIRST_SIZE[0] >> level,
            half.shape[1],
        )
        # What the grid makes of a constant corrects it; what the cut series falls short
        # by is below no light.
        levels.append(np.maximum(found / found[..., 3:], 0.0))
    return [level.astype(np.float32) for level in levels]


def lobe_gains(alpha: float, degrees: int) -> FloatArray:
    """Return by what the lobe multiplies harmonics of degree 0, 1, ...: 1 for degree 0.

    The lobe at angle t from its axis is D(t / 2) cos(t), D the distribution of GGX.
    """
    # Points crowd where the lobe is: half angles t / 2 = atan(alpha tan(x)) up to pi / 4.
    # Of 64 parts, because the nodes of one rule of that order alone take longer than all else.
    node, weight = np.polynomial.legendre.leggauss(16)
    part = np.arctan(1.0 / alpha) / 64.0
    x = (np.arange(64)[:, None] + 0.5 * (node + 1.0)).ravel() * part
    weight = np.tile(weight, 64)
    half = np.arctan(alpha * np.tan(x))
    step = alpha / (np.cos(x) ** 2 * (1.0 + (alpha * np.tan(x)) ** 2))
    cosine, sine = np.cos(2.0 * half), np.sin(2.0 * half)
    width = (alpha * np.cos(half)) ** 2 + np.sin(half) ** 2
    lobe = weight * step * sine * cosine / width**2
    lobe /= lobe.sum()
    gains = np.empty(degrees)
    before, now = np.zeros_like(cosine), np.ones_like(cosine)
    for degree in range(degrees):
        gains[degree] = lobe @ now
        following = ((2 * degree + 1) * cosine * now - degree * before) / (degree + 1)
        before, now = now, following
    return gains


def _resized(image: FloatArray, height: int, width: int) -> FloatArray:
    """Average `image` over larger texels, by solid angle; smaller ones repeat it."""
    rows = overlaps(cosine_edges(image.shape[0]), cosine_edges(height))
    columns = overlaps(np.linspace(0, 1, image.shape[1] + 1), np.linspace(0, 1, width + 1))
    return np.asarray(columns @ np.tensordot(rows, image, 1))


def _legendre(cosine: FloatArray, degrees: int) -> FloatArray:
    """Return the normalised associated functions of degree l and order m <= l, (l, m, n).

    The standard forward recursion in degree (Holmes and Featherstone 2002).
    """
    sine = np.sqrt(np.maximum(1.0 - cosine**2, 0.0))
    table = np.zeros((degrees, degrees, len(cosine)))
    table[0, 0] = np.sqrt(0.25 / np.pi)
    for degree in range(1, degrees):
        m = np.arange(degree, dtype=float)[:, None]
        a = np.sqrt((4.0 * degree**2 - 1.0) / (degree**2 - m**2))
        b = np.sqrt(np.maximum((degree - 1.0) ** 2 - m**2, 0.0) / (4.0 * (degree - 1.0) ** 2 - 1.0))
        before = table[degree - 2, :degree] if degree > 1 else 0.0
        table[degree, :degree] = a * (cosine * table[degree - 1, :degree] - b * before)
        scale = np.sqrt((2.0 * degree + 1.0) / (2.0 * degree))
        table[degree, degree] = scale * sine * table[degree - 1, degree - 1]
    return table


def _transformed(image: FloatArray) -> NDArray[np.complex128]:
    """Return the harmonics of an image by degree and order, (l, m, channels)."""
    height, width, channels = image.shape
    edges = np.linspace(0.0, np.pi, height + 1)
    # The mean cosine of a row, where light spread over it is best looked at.
    cosine = 0.5 * (np.cos(edges[:-1]) + np.cos(edges[1:]))
    weight = np.diff(1.0 - np.cos(edges)) * (2.0 * np.pi / width)
    orders = np.zeros((_DEGREES, height, channels), complex)
    spectrum = np.moveaxis(np.fft.rfft(image, axis=1), 1, 0)[:_DEGREES]
    orders[: len(spectrum)] = spectrum * weight[:, None]
    by_order = np.moveaxis(_legendre(cosine, _DEGREES), 1, 0)
    return np.moveaxis(by_order @ orders.real + 1j * (by_order @ orders.imag), 0, 1)


def _synthesised(
    harmonics: NDArray[np.complex128], height: int, width: int, source_width: int
) -> FloatArray:
    """Return the image (height, width, channels) of harmonics, at its texels' centres.

    They were transformed from an image `source_width` texels wide.
    """
    degrees, _, channels = harmonics.shape
    cosine = np.cos((np.arange(height) + 0.5) * np.pi / height)
    by_order = np.transpose(_legendre(cosine, degrees), (1, 2, 0))
    values = np.moveaxis(harmonics, 1, 0)
    rows = by_order @ values.real + 1j * (by_order @ values.imag)
    # Both images count from the centre of their first texel.
    turned = (
        rows
        * np.exp(1j * np.arange(degrees) * (np.pi / width - np.pi / source_width))[:, None, None]
    )
    kept = np.zeros((width // 2 + 1, height, channels), complex)
    count = min(degrees, len(kept))
    kept[:count] = turned[:count]
    return np.asarray(np.fft.irfft(np.moveaxis(kept, 0, 1), n=width, axis=1) * width)
