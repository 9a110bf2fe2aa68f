"""Distant light as images: radiance for lookups, and unoccluded irradiance.

Irradiance is E(n) = integral over the sphere of L(w) max(0, n.w) dw.
"""

from __future__ import annotations

import numpy as np

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.environment.environment_kinds import (
    ConstantEnvironment,
    Environment,
    GradientEnvironment,
    MapEnvironment,
    texels,
)

# Larger maps are averaged down, smaller ones divided up, to this grid of patches. Of a
# patch that the horizon cuts only the mean direction counts, which loses up to 3e-4 of
# E; dividing by what a constant map of 1 loses makes constant maps exact. Averaging
# moves light by at most half a patch, 1.4 degrees.
_PATCH_ROWS, _PATCH_COLUMNS = 64, 128
# Rows of the gradient's image: it is linear in the sine of the elevation, and 256 of
# them resolve that to 0.6 %.
_GRADIENT_ROWS = 256
_NORMALS_AT_ONCE = 512


def radiance_image(environment: Environment) -> FloatArray:
    """Return a lat-long image of an environment in world orientation.

    Returns
    -------
    ndarray, shape (height, width, 3), float64
        Row 0 is +y; -z is the middle column and +x a quarter to the right of it.
        1 x 1 for a constant environment, 256 x 4 for a gradient (each row's mean
        elevation), the map's own size for a map.
    """
    if isinstance(environment, ConstantEnvironment):
        return np.array(environment.radiance, dtype=np.float64).reshape(1, 1, 3)
    if isinstance(environment, GradientEnvironment):
        return np.repeat(environment.sample(texels(_GRADIENT_ROWS, 1)[0]), 4, axis=1)
    return environment.world_image()


def irradiance(environment: Environment, normals_ws: FloatArray) -> FloatArray:
    """Return unoccluded irradiance (..., 3) for unit normals (..., 3), float64.

    Exact for constant and gradient environments; for maps see `_PATCH_ROWS`.
    """
    normals = np.asarray(normals_ws, dtype=np.float64)
    if isinstance(environment, ConstantEnvironment):
        constant = np.pi * np.asarray(environment.radiance, dtype=np.float64)
        return np.broadcast_to(constant, normals.shape).copy()
    if isinstance(environment, GradientEnvironment):
        zenith, horizon, ground = (
            np.asarray(color, dtype=np.float64)
            for color in (environment.zenith, environment.horizon, environment.ground)
        )
        above = clamped_cosine_overlap(normals[..., 1:2])
        below = clamped_cosine_overlap(-normals[..., 1:2])
        return np.asarray(np.pi * horizon + (zenith - horizon) * above + (ground - horizon) * below)
    return _map_irradiance(environment, normals)


def clamped_cosine_overlap(cosine: FloatArray) -> FloatArray:
    """Return the integral of max(0, w.a) max(0, w.b) dw over the sphere, cosine = a.b.

    The lune in which both cosines are positive spans azimuths of length pi - angle
    about a x b; with the polar angle measured from a x b, the integrand separates:
    the integral of sin^3 is 4/3, that of the two azimuthal cosines
    (sin(angle) + (pi - angle) cos(angle)) / 2.
    """
    cosine = np.clip(cosine, -1.0, 1.0)
    angle = np.arccos(cosine)
    return np.asarray(2.0 / 3.0 * (np.sin(angle) + (np.pi - angle) * cosine))


def _map_irradiance(environment: MapEnvironment, normals: FloatArray) -> FloatArray:
    image = environment.world_image()
    height, width = image.shape[:2]
    row_count = _patch_count(height, _PATCH_ROWS)
    rows = overlaps(cosine_edges(height), cosine_edges(row_count))
    column_count = _patch_count(width, _PATCH_COLUMNS)
    columns = overlaps(np.linspace(0, 1, width + 1), np.linspace(0, 1, column_count + 1))
    patches = np.einsum("rh,hwc,kw->rkc", rows, image, columns, optimize=True)
    # The vector irradiance of each patch, integral of w dw, in closed form: a patch
    # wholly above the horizon then counts exactly.
    polar = np.linspace(0.0, np.pi, len(rows) + 1)
    azimuth = np.linspace(-np.pi, np.pi, len(columns) + 1)
    sine_squared = np.diff(0.5 * polar - 0.25 * np.sin(2.0 * polar))
    sine_cosine = np.diff(0.5 * np.sin(polar) ** 2)
    # The middle column looks along -z: x = sin(azimuth), z = -cos(azimuth).
    across, along = np.diff(-np.cos(azimuth)), np.diff(-np.sin(azimuth))
    vector = np.stack(
        [
            np.outer(sine_squared, across),
            np.outer(sine_cosine, np.diff(azimuth)),
            np.outer(sine_squared, along),
        ],
        axis=-1,
    ).reshape(-1, 3)
    radiance = patches.reshape(-1, 3)
    flat = normals.reshape(-1, 3)
    result = np.empty_like(flat)
    for start in range(0, len(flat), _NORMALS_AT_ONCE):
        weight = np.maximum(flat[start : start + _NORMALS_AT_ONCE] @ vector.T, 0.0)
        weight *= np.pi / weight.sum(axis=1, keepdims=True)
        result[start : start + _NORMALS_AT_ONCE] = weight @ radiance
    return np.asarray(result.reshape(normals.shape))


def _patch_count(texels: int, wanted: int) -> int:
    """Return a number of patches: `wanted`, or a multiple of fewer texels above it."""
    return wanted if texels >= wanted else texels * -(-wanted // texels)


def cosine_edges(count: int) -> FloatArray:
    """Return 1 - cosine at the edges of rows, by which solid angle is linear: 0 to 2."""
    return 1.0 - np.cos(np.linspace(0.0, np.pi, count + 1))


def overlaps(source: FloatArray, target: FloatArray) -> FloatArray:
    """Return (T, S) weights that average S source cells into T target cells by overlap.

    Parameters
    ----------
    source, target : ndarray, shape (S + 1,), (T + 1,)
        Edges of the cells, ascending.
    """
    low = np.maximum(target[:-1, None], source[None, :-1])
    high = np.minimum(target[1:, None], source[None, 1:])
    shared = np.maximum(high - low, 0.0)
    return np.asarray(shared / shared.sum(axis=1, keepdims=True))
