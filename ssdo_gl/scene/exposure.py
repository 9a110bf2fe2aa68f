"""An exposure that suits the light a model file brings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.light import DirectionalLight, Light, PointLight, RectangleLight
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
    light reaches any.
    """
    points, normals = _surface_samples(meshes, objects)
    total = np.zeros(len(points))
    for light in lights:
        total += _irradiance(light, points, normals)
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


def _irradiance(light: Light, points: FloatArray, normals: FloatArray) -> FloatArray:
    """Return unshadowed irradiance (N,), mean over colours, on the better lit side."""
    if isinstance(light, DirectionalLight):
        cosine = np.abs(normals @ math3d.normalized(light.direction))
        return np.asarray(cosine * np.mean(light.irradiance))
    if isinstance(light, RectangleLight):
        edges = np.asarray(light.edge_u), np.asarray(light.edge_v)
        area_vector = np.cross(*edges)
        area = float(np.linalg.norm(area_vector))
        offset = np.asarray(light.corner) + 0.5 * (edges[0] + edges[1]) - points
        # Adding the disk of the same area keeps the nearest points finite.
        squared = (offset**2).sum(axis=1) + area / np.pi
        distance = np.sqrt(squared)
        emitted = -(offset @ area_vector) / distance
        emitted = np.abs(emitted) if light.two_sided else np.maximum(emitted, 0.0)
        cosine = np.abs((offset * normals).sum(axis=1)) / distance
        return np.asarray(emitted * cosine / squared * np.mean(light.radiance))
    offset = np.asarray(light.position) - points
    squared = np.maximum((offset**2).sum(axis=1), 1e-12 * float(np.ptp(points) ** 2) or 1.0)
    direction = offset / np.sqrt(squared)[:, None]
    cosine = np.abs((direction * normals).sum(axis=1))
    if not isinstance(light, PointLight):
        aim = -(direction @ math3d.normalized(light.direction))
        cosine = np.where(aim > np.cos(np.radians(light.outer_angle)), cosine, 0.0)
    return np.asarray(cosine / squared * np.mean(light.intensity))
