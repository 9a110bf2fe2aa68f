"""The scene at a moment: motions applied to objects and lights."""

from __future__ import annotations

import dataclasses

from ssdo_gl.scene.lights import Light
from ssdo_gl.scene.mesh import SceneObject
from ssdo_gl.scene.scene import Scene


def scene_at(scene: Scene, seconds: float) -> Scene:
    """Return the scene as it stands `seconds` after rest.

    The very same scene if nothing in it moves, so that callers can tell by identity;
    what does not move is shared with the scene at rest.
    """
    moving: list[SceneObject | Light] = [*scene.objects, *scene.lights]
    if not any(item.motion for item in moving):
        return scene
    return dataclasses.replace(
        scene,
        objects=tuple(_object_at(item, seconds) for item in scene.objects),
        lights=tuple(light.at(seconds) for light in scene.lights),
    )


def _object_at(item: SceneObject, seconds: float) -> SceneObject:
    if item.motion is None:
        return item
    moved = item.motion.world_from_rest(seconds) @ item.world_from_object
    return dataclasses.replace(item, world_from_object=moved)
