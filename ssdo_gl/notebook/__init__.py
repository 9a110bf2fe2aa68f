"""What notebooks show: a scene to fly through, or a still picture of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ssdo_gl.image_requests import asked_scene
from ssdo_gl.options.resolve import for_pictures
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene


def view(
    source: str | Path | Scene,
    *,
    camera: Camera | str | int | None = None,
    size: tuple[int, int] = (640, 360),
    backend: str = "auto",
    **settings: Any,
) -> Any:
    """Show a scene in a notebook, to be turned with the mouse.

    Parameters
    ----------
    source : str, Path or Scene
        A scene file, a model file, the name of a built-in scene, or a Scene.
    camera : Camera, str or int, optional
        Where the flight begins, as for `ssdo_gl.render`; None: the scene's.
    size : (int, int)
        Width and height, CSS pixels; a narrower page makes it smaller.
    **settings
        Fields of `Settings` and `LoadOptions`, as for `ssdo_gl.render`.

    Returns
    -------
    FlyWidget or RenderResult
        A widget for Jupyter, VS Code and marimo, whose ``camera`` says where one has flown
        to. Without the extra ``notebook``, or for readers that show no widgets, a still
        picture.

    Raises
    ------
    SceneError, SettingError, ContextError
    """
    scene, place, chosen = asked_scene(source, camera, {**settings, "size": size})
    with Renderer(scene, for_pictures(chosen, scene), backend=backend) as renderer:
        still = renderer.render(["display"], camera=place)
    try:
        from ssdo_gl.notebook.fly_widget import FlyWidget
    except ImportError as error:
        if error.name not in ("anywidget", "traitlets"):
            raise
        print("ssdo_gl.view: a still picture; pip install 'ssdo_gl[notebook]' to turn it")
        return still
    return FlyWidget(
        scene,
        chosen,
        place or scene.camera,
        size,
        still._repr_png_() or b"",
        source=scene.title or "scene" if isinstance(source, Scene) else str(source),
        backend=backend,
    )
