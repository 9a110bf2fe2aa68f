"""What a scene made by hand may have wrong, told before anything is drawn."""

from __future__ import annotations

from typing import NoReturn

from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment import (
    ConstantEnvironment,
    GradientEnvironment,
    MapEnvironment,
)
from ssdo_gl.scene.geometry import Mesh, SceneObject
from ssdo_gl.scene.lights import Light
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene, SceneError

_KINDS = {"meshes": Mesh, "materials": Material, "objects": SceneObject, "lights": Light}
_ENVIRONMENTS = (ConstantEnvironment, GradientEnvironment, MapEnvironment)


def check_scene(scene: Scene) -> None:
    """Raise SceneError naming the first part of a scene that cannot be drawn, and the cure."""
    if not isinstance(scene, Scene):
        raise SceneError(f"scene: expected a Scene, got a {type(scene).__name__}")
    for name, kind in _KINDS.items():
        for index, item in enumerate(getattr(scene, name)):
            if not isinstance(item, kind):
                _wrong_type(f"{name}[{index}]", kind.__name__, item)
    if not isinstance(scene.camera, Camera):
        _wrong_type("camera", "Camera", scene.camera)
    if scene.environment is not None and not isinstance(scene.environment, _ENVIRONMENTS):
        _wrong_type("environment", "environment", scene.environment)
    for index, mesh in enumerate(scene.meshes):
        if mesh.fault:
            raise SceneError(f"meshes[{index}].{mesh.fault}")
    for index, item in enumerate(scene.objects):
        _check_object(scene, item, f"objects[{index}]")


def _check_object(scene: Scene, item: SceneObject, where: str) -> None:
    counts = {"mesh": scene.meshes, "material": scene.materials, "light": scene.lights}
    for name, parts in counts.items():
        index = getattr(item, name)
        if index is not None and not 0 <= index < len(parts):
            raise SceneError(f"{where}.{name} = {index}: the scene has {len(parts)}")
    if item.fault:
        raise SceneError(f"{where}.{item.fault}")


def _wrong_type(where: str, wanted: str, item: object) -> NoReturn:
    raise SceneError(f"{where}: expected a {wanted}, got a {type(item).__name__}")
