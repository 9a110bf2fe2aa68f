"""Pictures of one scene from many cameras, as data sets need them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from ssdo_gl.image_requests import asked_scene, checked_camera, images_of
from ssdo_gl.render_result import RenderResult
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings.fields import SettingError, shown
from ssdo_gl.settings.settings import Settings


def render_views(
    source: str | Path | Scene,
    cameras: Iterable[Camera],
    *,
    aov: str | Iterable[str] = "beauty",
    seconds: float = 0.0,
    backend: str = "auto",
    **settings: Any,
) -> Iterator[RenderResult]:
    """Yield what each of many cameras sees, one after the other, on one device.

    Parameters
    ----------
    source : str, Path or Scene
        A scene file, a model file, the name of a built-in scene, or a Scene.
    aov : str or iterable of str
        Images to make (`ssdo_gl.settings.AOVS`, or ``display``), or ``all``.
    seconds : float
        Time of an animated scene.
    **settings
        Fields of `Settings` and `LoadOptions`, as for `ssdo_gl.render`.

    Yields
    ------
    RenderResult
        Each with `images` of its own and its `camera`, whose `intrinsics`, `extrinsics`,
        `pose` and `projection` are the matrices in the conventions of OpenCV and OpenGL.
        The exposure of ``display`` is that of the first.

    Raises
    ------
    SceneError, SettingError, ContextError
        What concerns the arguments, before anything is drawn.

    Examples
    --------
    >>> import ssdo_gl
    >>> scene = ssdo_gl.load_scene("corner")
    >>> around = [scene.camera.orbit(degrees) for degrees in (0, 10, 20)]
    >>> views = ssdo_gl.render_views(scene, around, aov=["depth"], size=(32, 18))
    >>> [view.images["depth"].shape for view in views]
    [(18, 32, 1), (18, 32, 1), (18, 32, 1)]
    """
    if not isinstance(cameras, Iterable):
        raise SettingError(f"cameras = {shown(cameras)}: expected several Cameras, as in a list")
    cameras = tuple(cameras)
    for index, camera in enumerate(cameras):
        if camera is None:
            raise SettingError(f"cameras[{index}]: expected a Camera, got None")
        checked_camera(camera, f"cameras[{index}]")
    names = images_of(aov)
    scene, _, chosen = asked_scene(source, None, settings)
    return _views(scene, chosen, cameras, names, seconds, backend)


def _views(
    scene: Scene,
    settings: Settings,
    cameras: tuple[Camera, ...],
    names: tuple[str, ...],
    seconds: float,
    backend: str,
) -> Iterator[RenderResult]:
    with Renderer(scene, settings, backend=backend) as renderer:
        for camera in cameras:
            yield renderer.render(names, camera=camera, seconds=seconds).whole()
