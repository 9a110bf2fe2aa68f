"""Near-field global illumination in OpenGL, with the error of every image.

The public names are `load_scene`, `Renderer`, `Settings` and `render`::

    import ssdo_gl
    image = ssdo_gl.render("model.glb", size=(1280, 720), method="bounce")
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

__all__ = ["Renderer", "Settings", "__version__", "load_scene", "render"]

if TYPE_CHECKING:
    from ssdo_gl.renderer import Renderer, render
    from ssdo_gl.scene.load import load_scene
    from ssdo_gl.settings import Settings

_HOMES = {
    "Renderer": "ssdo_gl.renderer",
    "Settings": "ssdo_gl.settings",
    "load_scene": "ssdo_gl.scene.load",
    "render": "ssdo_gl.renderer",
}


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used, so that plain data needs no OpenGL."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import importlib

    return getattr(importlib.import_module(_HOMES[name]), name)
