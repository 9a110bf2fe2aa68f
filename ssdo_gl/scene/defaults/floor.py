"""A floor under a lone model: it catches its shadow, and sends light back to it."""

from __future__ import annotations

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray, IntArray
from ssdo_gl.scene.defaults.default_light import BACKDROP
from ssdo_gl.scene.environment import Environment, irradiance
from ssdo_gl.scene.geometry import Mesh, Surfaces, corners_within, main_part, placed
from ssdo_gl.scene.lights import DirectionalLight
from ssdo_gl.scene.material import Material

_SEGMENTS = 96
# Below the model, so that it does not fight with what lies at its bottom; of its size.
_GAP = 1e-4
# Surfaces that look up at the bottom twentieth of a scene and cover this share of it are a
# floor of its own.
_FLOOR_HEIGHT, _FLOOR_SHARE = 0.05, 0.3
# Of more copies a share says enough.
_MAX_COPIES = 256
# Beyond this the floor would have to be brighter than white.
_MAX_ALBEDO = 0.8


def has_floor(surfaces: Surfaces) -> bool:
    """Return whether a scene brings something that the rest stands on."""
    parts: list[tuple[IntArray, FloatArray]] = []
    lows, highs = [], []
    for item in surfaces.objects:
        mesh, copies = surfaces.mesh(item), item.world_from_object
        is_used = np.zeros(len(mesh.positions), dtype=bool)
        is_used[mesh.triangles] = True
        points = placed(mesh.positions, copies[:: 1 + len(copies) // _MAX_COPIES])
        parts.append((mesh.triangles, points))
        lows.append(points[:, is_used].min(axis=(0, 1)))
        highs.append(points[:, is_used].max(axis=(0, 1)))
    low, high = np.min(lows, axis=0), np.max(highs, axis=0)
    part = main_part(surfaces)
    if not part.is_all:
        low, high = part.low, part.high
    floor = low[1] + _FLOOR_HEIGHT * (high[1] - low[1])
    covered = 0.0
    for triangles, points in parts:
        flat = corners_within(points, triangles, points[..., 1] <= floor)
        covered += 0.5 * float(np.maximum(math3d.doubled_area_vectors(flat)[:, 1], 0.0).sum())
    return covered >= _FLOOR_SHARE * float((high[0] - low[0]) * (high[2] - low[2]))


def ground(
    bounds: tuple[FloatArray, FloatArray], environment: Environment, key: DirectionalLight
) -> tuple[Mesh, Material]:
    """Return a disc under `bounds`, and a material that shows the backdrop in this light.

    It reaches as far as shadows of the default key light fall; it has no edge to be seen.
    """
    low, high = bounds
    size = high - low
    radius = 0.75 * float(np.hypot(size[0], size[2])) + 1.2 * float(size[1])
    middle = 0.5 * (low + high)
    middle[1] = low[1] - _GAP * float(size.max())
    angle = np.arange(_SEGMENTS) * (-2.0 * np.pi / _SEGMENTS)
    rim = middle + radius * np.stack([np.cos(angle), np.zeros(_SEGMENTS), np.sin(angle)], axis=1)
    around = np.arange(_SEGMENTS)
    triangles = np.stack([np.full(_SEGMENTS, _SEGMENTS), around, np.roll(around, -1)], axis=1)
    mesh = Mesh(np.concatenate([rim, middle[None]]), triangles, name="ground")
    up = np.array([0.0, 1.0, 0.0])
    cosine = max(float(-math3d.normalized(key.direction) @ up), 0.0)
    arriving = irradiance(environment, up[None])[0] + cosine * np.asarray(key.irradiance)
    albedo = np.pi * np.asarray(BACKDROP) / np.maximum(arriving, 1e-9)
    red, green, blue = np.minimum(albedo, _MAX_ALBEDO)
    # From below one looks through it.
    material = Material(
        name="ground", albedo=(float(red), float(green), float(blue)), single_sided=True
    )
    return mesh, material
