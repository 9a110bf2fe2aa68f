"""Near-field global illumination in OpenGL, with the error of every image.

A picture is one call; a `Renderer` keeps what many have in common::

    import ssdo_gl
    image = ssdo_gl.render("model.glb", size=(1280, 720), method="bounce")

A `Scene` is read by `load_scene`, or made by ``Scene.from_arrays``, ``Scene.from_trimesh`` and
``add``. ``dir(ssdo_gl)`` lists all public names.
"""

from __future__ import annotations

# In place of that of typing, of which an early Ctrl-C would be a traceback.
TYPE_CHECKING = False

__all__ = [
    "Camera",
    "ConstantEnvironment",
    "DirectionalLight",
    "GradientEnvironment",
    "MapEnvironment",
    "Material",
    "Mesh",
    "PointLight",
    "RectangleLight",
    "RenderResult",
    "Renderer",
    "Scene",
    "SceneError",
    "SceneObject",
    "SettingError",
    "Settings",
    "SpotLight",
    "Texture",
    "__version__",
    "film_frames",
    "load_scene",
    "render",
    "render_film",
    "render_views",
    "transform_matrix",
    "view",
]

if TYPE_CHECKING:
    from typing import Any

    from ssdo_gl.headless.film_interface import film_frames, render_film
    from ssdo_gl.headless.many_views import render_views
    from ssdo_gl.math3d import transform_matrix
    from ssdo_gl.notebook import view
    from ssdo_gl.render_result import RenderResult
    from ssdo_gl.renderer import Renderer, render
    from ssdo_gl.scene.camera import Camera
    from ssdo_gl.scene.environment import (
        ConstantEnvironment,
        GradientEnvironment,
        MapEnvironment,
    )
    from ssdo_gl.scene.geometry import Mesh, SceneObject
    from ssdo_gl.scene.lights import DirectionalLight, PointLight, RectangleLight, SpotLight
    from ssdo_gl.scene.load import load_scene
    from ssdo_gl.scene.material import Material, Texture
    from ssdo_gl.scene.scene import Scene
    from ssdo_gl.scene.scene_error import SceneError
    from ssdo_gl.settings import Settings
    from ssdo_gl.settings.fields import SettingError
    from ssdo_gl.version import __version__

_HOMES = {
    "__version__": "ssdo_gl.version",
    "Camera": "ssdo_gl.scene.camera",
    "ConstantEnvironment": "ssdo_gl.scene.environment",
    "DirectionalLight": "ssdo_gl.scene.lights",
    "GradientEnvironment": "ssdo_gl.scene.environment",
    "MapEnvironment": "ssdo_gl.scene.environment",
    "Material": "ssdo_gl.scene.material",
    "Mesh": "ssdo_gl.scene.geometry",
    "PointLight": "ssdo_gl.scene.lights",
    "RectangleLight": "ssdo_gl.scene.lights",
    "RenderResult": "ssdo_gl.render_result",
    "Renderer": "ssdo_gl.renderer",
    "Scene": "ssdo_gl.scene.scene",
    "SceneError": "ssdo_gl.scene.scene_error",
    "SceneObject": "ssdo_gl.scene.geometry",
    "SettingError": "ssdo_gl.settings.fields",
    "Settings": "ssdo_gl.settings",
    "SpotLight": "ssdo_gl.scene.lights",
    "Texture": "ssdo_gl.scene.material",
    "film_frames": "ssdo_gl.headless.film_interface",
    "load_scene": "ssdo_gl.scene.load",
    "render": "ssdo_gl.renderer",
    "render_film": "ssdo_gl.headless.film_interface",
    "render_views": "ssdo_gl.headless.many_views",
    "transform_matrix": "ssdo_gl.math3d",
    "view": "ssdo_gl.notebook",
}


def __dir__() -> list[str]:
    """Return the public names, also those that are not imported yet."""
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used, so that plain data needs no OpenGL."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import importlib

    return getattr(importlib.import_module(_HOMES[name]), name)
