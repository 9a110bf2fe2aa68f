"""What a scene made by hand may have wrong, told before anything is drawn."""

from __future__ import annotations

from typing import get_args

from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment import Environment
from ssdo_gl.scene.geometry import Mesh, SceneObject
from ssdo_gl.scene.lights import Light
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene_data import SceneData
from ssdo_gl.scene.scene_error import SceneError, check_type

_KINDS = {"meshes": Mesh, "materials": Material, "objects": SceneObject, "lights": Light}


def check_scene(scene: SceneData) -> None:
    """Raise SceneError naming the first part of a scene that cannot be drawn, and the cure."""
    check_type("scene", scene, SceneData, "Scene")
    for name, kind in _KINDS.items():
        for index, item in enumerate(getattr(scene, name)):
            check_type(f"{name}[{index}]", item, kind)
    check_type("camera", scene.camera, Camera)
    if scene.environment is not None:
        check_type("environment", scene.environment, get_args(Environment), "environment")
    for index, mesh in enumerate(scene.meshes):
        if mesh.fault:
            raise SceneError(f"meshes[{index}].{mesh.fault}")
    for index, item in enumerate(scene.objects):
        _check_object(scene, item, f"objects[{index}]")


def _check_object(scene: SceneData, item: SceneObject, where: str) -> None:
    counts = {"mesh": scene.meshes, "material": scene.materials, "light": scene.lights}
    for name, parts in counts.items():
        index = getattr(item, name)
        if index is not None and not 0 <= index < len(parts):
            raise SceneError(f"{where}.{name} = {index}: the scene has {len(parts)}")
    if item.fault:
        raise SceneError(f"{where}.{item.fault}")
