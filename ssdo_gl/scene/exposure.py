"""An exposure that suits the light a model file brings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.lights import Light
from ssdo_gl.scene.mesh import Mesh, SceneObject

# Radiance that a light grey surface gets from direct light alone at the brighter end
# of the scene; indirect light adds about half as much again in a room.
_TARGET_RADIANCE, _GREY, _PERCENTILE = 0.3, 0.8, 75.0
_SAMPLES = 2000


def exposure_for(
    meshes: Sequence[Mesh], objects: Sequence[SceneObject], lights: Sequence[Light]
) -> float:
    """Return the exposure in EV at which a scene of unknown light shows well.

    From the unshadowed irradiance at points spread evenly over the surfaces; 0 if no
    light reaches any, or if all of them are lamps.
    """
    points, normals = _surface_samples(meshes, objects)
    if not len(points):
        return 0.0
    total = np.zeros(len(points))
    for light in lights:
        total += light.irradiance_at(points, normals)
    reached = total[total > 0.0]
    if not len(reached):
        return 0.0
    level = float(np.percentile(reached, _PERCENTILE)) * _GREY / np.pi
    return float(np.round(np.log2(_TARGET_RADIANCE / level), 1))


def _surface_samples(
    meshes: Sequence[Mesh], objects: Sequence[SceneObject]
) -> tuple[FloatArray, FloatArray]:
    """Return centres and unit normals (N, 3) of triangles, evenly by area."""
    corners = np.concatenate(
        [
            math3d.transform_points(matrix, meshes[o.mesh].positions)[meshes[o.mesh].triangles]
            for o in objects
            if o.light is None
            for matrix in o.world_from_object
        ]
        or [np.zeros((0, 3, 3))]
    )
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = np.linalg.norm(cross, axis=1)
    cumulative = np.cumsum(doubled)
    if not len(cumulative) or cumulative[-1] <= 0.0:
        return np.zeros((0, 3)), np.zeros((0, 3))
    level = (np.arange(_SAMPLES) + 0.5) / _SAMPLES * cumulative[-1]
    chosen = np.searchsorted(cumulative, level)
    # The golden ratio and its square spread the points over each triangle.
    a, b = (np.arange(_SAMPLES) * step % 1.0 for step in (0.618033988749895, 0.754877666246693))
    root = np.sqrt(a)
    weight = np.stack([1.0 - root, root * (1.0 - b), root * b], axis=1)
    points = np.einsum("pk,pkc->pc", weight, corners[chosen])
    return points, cross[chosen] / doubled[chosen, None]
