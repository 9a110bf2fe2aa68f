"""Films from Python: to files, or frame by frame."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ssdo_gl.farm.scheduler import check_scheduler
from ssdo_gl.film.bookmarks import load_path
from ssdo_gl.film.camera_path import CameraPath
from ssdo_gl.film.shots import Shots
from ssdo_gl.headless.film import make_film
from ssdo_gl.headless.film_frames import FilmRequest, rendered_frames, shows_pictures
from ssdo_gl.image_requests import asked_scene, images_of
from ssdo_gl.images.surface_arrays import Image
from ssdo_gl.options.resolve import for_pictures
from ssdo_gl.options.run_options import FRAMES_PER_SECOND
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene


@dataclass(frozen=True)
class FilmFrame:
    """One frame of `film_frames`.

    Attributes
    ----------
    seconds : float
        Time of an animated scene.
    camera : Camera or None
        None: the scene's own at that time.
    images : dict of str to ndarray, shape (height, width, channels), float32
        Row 0 at the top.
    """

    index: int
    seconds: float
    camera: Camera | None
    images: dict[str, Image] = field(repr=False)


def film_frames(
    source: str | Path | Scene,
    *,
    path: CameraPath | str | Path | None = None,
    turntable: float | None = None,
    fps: float = FRAMES_PER_SECOND,
    frames: tuple[int, int] | tuple[int, int, int] | None = None,
    time: float = 0.0,
    camera: Camera | str | int | None = None,
    aov: str | Iterable[str] = "beauty",
    backend: str = "auto",
    **settings: Any,
) -> Iterator[FilmFrame]:
    """Yield the frames of a film one by one, as arrays.

    Parameters
    ----------
    source : str, Path or Scene
        A scene file, a model file, the name of a built-in scene, or a Scene.
    path : CameraPath, str or Path, optional
        What the camera follows, or a file of the window's with a recorded path.
    turntable : float, optional
        Degrees that the camera turns about its target in the whole film.
    fps : float
        Frames per second.
    frames : tuple, optional
        (A, B): frames A to B - 1 of a film of B; (A, B, LENGTH): of LENGTH frames.
    time : float
        Time of an animated scene in frame 0, seconds.
    camera : Camera, str or int, optional
        Replaces the scene's camera, as for `ssdo_gl.render`.
    aov : str or iterable of str
        Images to make (`ssdo_gl.settings.AOVS`, or ``display``), or ``all``.
    **settings
        Fields of `Settings` and `LoadOptions`, as for `ssdo_gl.render`.

    Raises
    ------
    SceneError, SettingError, ContextError
    """
    shots = _shots(path, turntable, fps, frames, time)
    names = images_of(aov)
    scene, place, chosen = asked_scene(source, camera, settings)
    with Renderer(scene, chosen, backend=backend) as renderer:
        for shot, result in rendered_frames(renderer, shots, names, place):
            yield FilmFrame(shot.index, shot.seconds, shot.camera, result.images)


def render_film(
    source: str | Path | Scene,
    out: str | Path,
    *,
    path: CameraPath | str | Path | None = None,
    turntable: float | None = None,
    fps: float = FRAMES_PER_SECOND,
    frames: tuple[int, int] | tuple[int, int, int] | None = None,
    time: float = 0.0,
    camera: Camera | str | int | None = None,
    aov: str | Iterable[str] = "beauty",
    resume: bool = False,
    scheduler: str | None = None,
    backend: str = "auto",
    **settings: Any,
) -> int:
    """Render a film to `out`; return how many frames were rendered.

    Parameters
    ----------
    out : str or Path
        ``.mp4``, ``.webm``, ``.webp``, ``.gif``; a folder of pictures; or a pattern of
        file names such as ``frame_%04d.exr``.
    resume : bool
        Render only the frames whose files are missing or empty.
    scheduler : str, optional
        Workers that render it: ``local``, ``local:N``, or the address of a Dask scheduler.
        A script that asks for local ones guards its main part by
        ``if __name__ == "__main__"``: they import it.

    The others are those of `film_frames`.

    Raises
    ------
    SceneError, SettingError, OutputError, FarmError, ContextError

    Examples
    --------
    >>> import tempfile, ssdo_gl
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     ssdo_gl.render_film("corner", folder, turntable=360, frames=(0, 2), size=(32, 18))
    2
    """
    shots = _shots(path, turntable, fps, frames, time)
    names = images_of(aov)
    if scheduler is not None:
        check_scheduler(scheduler)
    out = Path(out)
    scene, place, chosen = asked_scene(source, camera, settings)
    return make_film(
        FilmRequest(
            scene=scene,
            settings=for_pictures(chosen, scene) if shows_pictures(out) else chosen,
            out=out,
            shots=shots,
            wanted=names,
            camera=place,
            backend=backend,
            resume=resume,
            scheduler=scheduler,
            quiet=True,
        )
    ).rendered_count


def _shots(
    path: CameraPath | str | Path | None,
    turntable: float | None,
    fps: float,
    frames: tuple[int, int] | tuple[int, int, int] | None,
    time: float,
) -> Shots:
    if path is not None and not isinstance(path, CameraPath):
        path = load_path(Path(path))
    return Shots(path, turntable, fps, time, frames)
