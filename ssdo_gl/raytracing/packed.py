"""What the corners of triangles carry, in as few bits as shaders read of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray

# Steps of a 16-bit octahedral component: as lib/octahedral.glsl, which makes 0 exact.
OCT_HALF_RANGE = 32767


def oct_words(normals: FloatArray) -> NDArray[np.uint32]:
    """Pack unit vectors (..., 3) into 32 bits, as lib/octahedral.glsl does."""
    x, y, z = np.moveaxis(normals, -1, 0)
    total = np.maximum(np.abs(x) + np.abs(y) + np.abs(z), np.finfo(np.float64).tiny)
    u, v = x / total, y / total
    folded_u = (1.0 - np.abs(v)) * np.where(u < 0.0, -1.0, 1.0)
    folded_v = (1.0 - np.abs(u)) * np.where(v < 0.0, -1.0, 1.0)
    u, v = np.where(z < 0.0, folded_u, u), np.where(z < 0.0, folded_v, v)
    steps = [np.rint((c + 1.0) * OCT_HALF_RANGE).astype(np.uint32) for c in (u, v)]
    return np.asarray(steps[0] | steps[1] << 16, dtype=np.uint32)


def unit_vectors(words: NDArray[np.uint32]) -> FloatArray:
    """Return what `oct_words` has packed, (..., 3)."""
    steps = np.stack([words & 0xFFFF, words >> 16], axis=-1).astype(np.float64)
    square = steps / OCT_HALF_RANGE - 1.0
    z = 1.0 - np.abs(square).sum(axis=-1, keepdims=True)
    square -= np.maximum(-z, 0.0) * np.where(square < 0.0, -1.0, 1.0)
    n = np.concatenate([square, z], axis=-1)
    return np.asarray(n / np.linalg.norm(n, axis=-1, keepdims=True))


def color_words(colors: FloatArray) -> NDArray[np.uint32]:
    """Pack colours (..., 4) of [0, 1] into two words (..., 2), 16 bits a channel."""
    steps = np.rint(np.clip(colors, 0.0, 1.0) * 65535.0).astype(np.uint32)
    return np.asarray(steps[..., ::2] | steps[..., 1::2] << 16)


def tangent_words(tangents: FloatArray) -> NDArray[np.uint32]:
    """Pack tangents (..., 4) into two words (..., 2): direction and handedness.

    0: no tangent, 1: right-handed, 3: left-handed.
    """
    hand = tangents[..., 3]
    signs = np.where(hand == 0.0, 0, 2 - hand).astype(np.uint32)
    return np.stack([oct_words(tangents[..., :3]), signs], axis=-1)
