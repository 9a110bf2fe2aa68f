"""Irradiance of polygon and point lights, float64. Imports nothing from ssdo_gl.

Everything is relative to the receiver at the origin. A light's corners run so that the
side it emits from sees them counter-clockwise.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def clip(polygon: Array, normal: Array) -> Array:
    """Return the part of a convex polygon (n, 3) above the plane through the origin."""
    result = []
    for a, b in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        height_a, height_b = a @ normal, b @ normal
        if height_a > 0.0:
            result.append(a)
        if (height_a > 0.0) != (height_b > 0.0):
            result.append(a + (b - a) * (height_a / (height_a - height_b)))
    return np.array(result).reshape(-1, 3)


def cosine_integral(corners: ArrayLike, normal: ArrayLike, geometric: ArrayLike) -> float:
    """Return the integral of cos(normal) over a polygon's solid angle, 0 on its dark side.

    Lambert's formula on the outline, clipped at both horizons (Sutherland-Hodgman).
    """
    corners, normal = np.asarray(corners, np.float64), np.asarray(normal, np.float64)
    if corners[0] @ np.cross(corners[1] - corners[0], corners[-1] - corners[0]) >= 0.0:
        return 0.0
    polygon = clip(clip(corners, np.asarray(geometric, np.float64)), normal)
    total = 0.0
    for a, b in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        product = np.cross(a, b)
        length = np.linalg.norm(product)
        if length > 0.0:
            total -= 0.5 * np.arctan2(length, a @ b) * (product @ normal) / length
    return float(total)


def cosine_integral_by_quadrature(
    corners: ArrayLike, normal: ArrayLike, geometric: ArrayLike, order: int = 64
) -> float:
    """Return the same from its definition, by Gauss-Legendre points on a parallelogram.

    Slowly convergent where a horizon cuts the light.
    """
    corners = np.asarray(corners, np.float64)
    u, v = corners[1] - corners[0], corners[3] - corners[0]
    nodes, weights = np.polynomial.legendre.leggauss(order)
    s, t = np.meshgrid(0.5 * (nodes + 1.0), 0.5 * (nodes + 1.0))
    points = corners[0] + s[..., None] * u + t[..., None] * v
    distance = np.linalg.norm(points, axis=-1)
    above = points @ np.asarray(geometric, np.float64) > 0.0
    receiver = np.maximum(points @ np.asarray(normal, np.float64), 0.0) * above
    emitter = np.maximum(-points @ np.cross(u, v), 0.0)
    return float(np.sum(np.outer(weights, weights) * 0.25 * receiver * emitter / distance**4))


def parallel_rectangle(a: float, b: float, c: float) -> float:
    """D1: form factor of an a x b rectangle parallel at distance c, a corner above the point."""
    x, y = a / c, b / c
    u, v = np.sqrt(1.0 + x * x), np.sqrt(1.0 + y * y)
    return float((x / u * np.arctan(y / u) + y / v * np.arctan(x / v)) / (2.0 * np.pi))


def perpendicular_rectangle(a: float, b: float, c: float) -> float:
    """D2: perpendicular rectangle of height a and width b whose foot is at distance c."""
    x, y = a / b, c / b
    r = np.sqrt(x * x + y * y)
    return float((np.arctan(1.0 / y) - y / r * np.arctan(1.0 / r)) / (2.0 * np.pi))


def spot_falloff(cosine: Array | float, inner_angle: float, outer_angle: float) -> Array:
    """KHR_lights_punctual: the squared linear ramp in the cosine; angles in degrees."""
    inner, outer = np.cos(np.radians([inner_angle, outer_angle]))
    return np.asarray(np.clip((cosine - outer) / (inner - outer), 0.0, 1.0) ** 2)
