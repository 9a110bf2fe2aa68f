"""The scene at a moment: motions and poses applied."""

from __future__ import annotations

import dataclasses

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry import Mesh, SceneObject, thickened, with_area
from ssdo_gl.scene.motion import Trajectory
from ssdo_gl.scene.scene import Scene

# Size of what is too small to be seen, relative to what it was.
_SPECK = 1e-6


def scene_at(scene: Scene, seconds: float) -> Scene:
    """Return the scene as it stands at `seconds`.

    The very same scene if nothing in it moves, so that callers can tell by identity;
    what does not move is shared with the scene at rest. What has no size at that time is
    left out.
    """
    if not scene.moves:
        return scene
    used = {item.mesh for item in scene.objects}
    posed = {
        index: mesh.pose(seconds)
        for index, mesh in enumerate(scene.meshes)
        if mesh.pose is not None and index in used
    }
    meshes = scene.meshes
    if posed:
        meshes = tuple(posed.get(index) or mesh for index, mesh in enumerate(meshes))
    moved = [
        _object_at(item, meshes[item.mesh], seconds)
        for item in scene.objects
        if posed.get(item.mesh, True) is not None
    ]
    shown = tuple(item for item in moved if len(item.world_from_object))
    return dataclasses.replace(
        scene,
        meshes=meshes,
        objects=shown or (_speck(scene),),
        lights=tuple(light.at(seconds) for light in scene.lights),
        camera=camera_at(scene.camera, scene.camera_motion, seconds),
    )


def _object_at(item: SceneObject, mesh: Mesh, seconds: float) -> SceneObject:
    if item.motion is None:
        return item
    moved = item.motion.world_from_rest(seconds) @ item.world_from_object
    if not item.motion.is_rigid:
        moved = thickened(with_area(moved), mesh)
    return dataclasses.replace(item, world_from_object=moved)


def _speck(scene: Scene) -> SceneObject:
    """Return what stands for a scene of which nothing shows: too small to be seen."""
    first = scene.objects[0]
    place = first.world_from_object[:1].copy()
    middle = place[0, :3, :3] @ scene.meshes[first.mesh].center()
    place[0, :3, :3] *= _SPECK
    place[0, :3, 3] += (1.0 - _SPECK) * middle
    return dataclasses.replace(first, world_from_object=place)


def camera_at(camera: Camera, motion: Trajectory | None, seconds: float) -> Camera:
    """Return a camera as its motion has it at `seconds`."""
    if motion is None:
        return camera
    matrix = motion.world_from_rest(seconds)
    position, target = (
        math3d.vector(math3d.transform_points(matrix, point))
        for point in (camera.position, camera.target)
    )
    up = math3d.vector(matrix[:3, :3] @ np.asarray(camera.up))
    return dataclasses.replace(camera, position=position, target=target, up=up)
