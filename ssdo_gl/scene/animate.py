"""The scene at a moment: motions applied to objects and lights."""

from __future__ import annotations

import dataclasses

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.light import DirectionalLight, Light, PointLight, RectangleLight, Vector
from ssdo_gl.scene.mesh import SceneObject
from ssdo_gl.scene.scene import Scene


def scene_at(scene: Scene, seconds: float) -> Scene:
    """Return the scene as it stands `seconds` after rest.

    The very same scene if nothing in it moves, so that callers can tell by identity;
    what does not move is shared with the scene at rest.
    """
    if not any(item.motion for item in (*scene.objects, *scene.lights)):
        return scene
    return dataclasses.replace(
        scene,
        objects=tuple(_object_at(item, seconds) for item in scene.objects),
        lights=tuple(_light_at(light, seconds) for light in scene.lights),
    )


def _object_at(item: SceneObject, seconds: float) -> SceneObject:
    if item.motion is None:
        return item
    moved = item.motion.world_from_rest(seconds) @ item.world_from_object
    return dataclasses.replace(item, world_from_object=moved)


def _light_at(light: Light, seconds: float) -> Light:
    if light.motion is None:
        return light
    matrix = light.motion.world_from_rest(seconds)
    if isinstance(light, DirectionalLight):
        return dataclasses.replace(light, direction=_turned(matrix, light.direction))
    if isinstance(light, RectangleLight):
        return dataclasses.replace(
            light,
            corner=_moved(matrix, light.corner),
            edge_u=_turned(matrix, light.edge_u),
            edge_v=_turned(matrix, light.edge_v),
        )
    position = _moved(matrix, light.position)
    if isinstance(light, PointLight):
        return dataclasses.replace(light, position=position)
    return dataclasses.replace(light, position=position, direction=_turned(matrix, light.direction))


def _moved(matrix: FloatArray, point: Vector) -> Vector:
    x, y, z = (float(value) for value in math3d.transform_points(matrix, point))
    return x, y, z


def _turned(matrix: FloatArray, vector: Vector) -> Vector:
    x, y, z = (float(value) for value in matrix[:3, :3] @ np.asarray(vector))
    return x, y, z
