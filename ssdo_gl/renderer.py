"""Renders frames of one scene: the program's Python interface."""

from __future__ import annotations

import dataclasses
import functools
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ssdo_gl.frame_loop import FrameJob, FrameLoop
from ssdo_gl.gpu.texture import read_texture
from ssdo_gl.graph.frame import FrameView
from ssdo_gl.graph.render_pass import ProgressCallback
from ssdo_gl.image_requests import asked_scene, checked_images
from ssdo_gl.images.average import ImageAverage, middle_index
from ssdo_gl.images.metering import FRAMED_MOST_RAISED, measured_exposure
from ssdo_gl.images.surface_arrays import (
    Image,
    camera_depths,
    world_normals,
    world_positions,
)
from ssdo_gl.render_result import Drawing, FrameLog, FrameTimes, RenderResult
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.backgrounds import background_color
from ssdo_gl.settings.methods import METHODS

# Longer side of the picture that exposure is measured from.
METERED_PX = 160
# Where more of the hemisphere is open, light from beyond the radius is most of it.
MOSTLY = 0.5
# Of one point each: where frames are averaged, they come from the pixel's centre.
GEOMETRY_AOVS = ("normal_ws", "position_ws", "depth")


class Renderer(FrameLoop):
    """Renders frames of one scene on a device of its own.

    Use it as a context manager; the device is released at the end. A renderer works in the
    thread that has made it, and raises RuntimeError in others, in a forked process, and
    once it was released.

    Parameters
    ----------
    scene : Scene
    settings : Settings or None
        Fields that were not given yield to the scene's own (``Scene.render``), as flags of
        the command line do. None: as the scene asks for.
    backend : str
        auto, egl, osmesa or window.
    device : Device or None
        An existing device to draw with; it is not released at the end.
    shaders : ShaderLibrary or None
        Of that device, so that several renderers compile each program once.
    shared : SharedScene or None
        Of that device and scene, so that several renderers upload and make what no view is
        part of once; it is not released at the end.

    Examples
    --------
    >>> from ssdo_gl import Renderer, Settings, load_scene
    >>> with Renderer(load_scene("corner"), Settings(size=(64, 36))) as renderer:
    ...     images = renderer.render(["beauty", "visibility"]).images
    >>> images["beauty"].shape, images["visibility"].shape
    ((36, 64, 4), (36, 64, 1))
    """

    def render(
        self,
        wanted: Iterable[str] = ("beauty",),
        *,
        camera: Camera | None = None,
        seconds: float = 0.0,
        frames: int = 1,
        time_passes: bool = False,
        progress: ProgressCallback | None = None,
    ) -> RenderResult:
        """Render and return `wanted` images.

        Parameters
        ----------
        wanted : iterable of str
            AOV names (`ssdo_gl.settings.AOVS`), or ``display`` for the tone-mapped
            picture in sRGB, [0, 1].
        camera : Camera or None
            Replaces the scene's camera.
        seconds : float
            Time of an animated scene.
        frames : int
            Frames that are timed. With more than one, warm-up frames come first
            and every frame recomputes all that depends on the view.
        time_passes : bool
            Time every pass, too.

        Raises
        ------
        SettingError
            Naming an image that does not exist, or a number out of range.
        """
        names = checked_images(wanted, frames)
        notes = self.expose(camera, seconds, progress) if "display" in names else ()
        averaged = tuple(n for n in names if n not in GEOMETRY_AOVS)
        count = self.settings.antialias if averaged else 1
        # A mean of depths or normals is no depth and no normal of anything.
        centres = self._at_centres(names, camera, seconds) if count > 1 else {}
        names = averaged if count > 1 else names
        job, log, average = self._prepare(names, camera, seconds), FrameLog(), ImageAverage()
        with average.ended_by_interrupt(job.references):
            for index in range(count):
                frame = self._frame(job.view, (middle_index(count) + index) % count, count)
                self._run(job.plan, frame, log, time_passes, progress)
                average.add(self._read(job, frame.view))
                job.check_whole()
                if progress and count > 1:
                    progress("anti-aliasing frames", index + 1, count)
        if frames > 1 and not average.is_interrupted:
            self._time_frames(job, log, count, frames, time_passes, progress)
        return RenderResult(
            images=centres | average.images(),
            view=job.view,
            size=self.settings.size,
            settings=self.settings,
            passes=log.reports(job.pipeline, job.plan),
            decisions=job.pipeline.decided.rows,
            frame_ms=log.frame_ms,
            setup_ms=log.setup_ms or 0.0,
            process_ms=log.process_ms,
            references=job.references(),
            partial=average.is_interrupted,
            notes=notes,
            camera=job.camera,
            metering_slack=self._slack,
        )

    def _time_frames(
        self,
        job: FrameJob,
        log: FrameLog,
        count: int,
        frames: int,
        time_passes: bool,
        progress: ProgressCallback | None,
    ) -> None:
        """Draw frames that compute a view again; for the first, programs are compiled for that."""
        for number in range(frames + 1):
            if number == 1:
                log.restart()
            frame = self._frame(job.view, 0, count, number + 1)
            self._run(job.plan, frame, log, time_passes, progress)
            job.check_whole()

    def expose(
        self,
        camera: Camera | None = None,
        seconds: float = 0.0,
        progress: ProgressCallback | None = None,
    ) -> tuple[str, ...]:
        """Measure the exposure of what `camera` sees, if that is left to the picture, once.

        From a small picture of `gi`, or for methods that show the near field alone of `bounce`,
        so that sizes and numbers of samples are shown alike. Returns what there is to say about it.
        """
        slack = self._slack
        if slack is None:
            return ()
        chosen, size = self.settings, self.settings.size
        longest = max(size)
        width, height = (max(1, n * METERED_PX // max(longest, METERED_PX)) for n in size)
        method = "gi" if METHODS[chosen.method].is_all_light else "bounce"
        self.use(Settings(method, size=(width, height), radius=chosen.radius, exposure=0.0))
        job = self._prepare(("beauty", "position_ws", "visibility"), camera, seconds)
        self._run(job.plan, self._frame(job.view, 0, 1), FrameLog(), False, progress)
        images = self._read(job, job.view)
        # The ground under a model is no part of it.
        lowest = self.scene.bounds()[0][1] if self.scene.has_ground else -np.inf
        images["beauty"][images["position_ws"][..., 1] < lowest] = 0.0
        most = FRAMED_MOST_RAISED if slack and self.scene.is_framed else np.inf
        exposure = measured_exposure(images["beauty"], slack, most)
        self.use(dataclasses.replace(chosen, exposure=exposure))
        self.scene = dataclasses.replace(
            self.scene,
            camera=dataclasses.replace(self.scene.camera, exposure=exposure),
            is_metered=True,
        )
        notes = [f"exposure {exposure:+.1f} EV, measured from the picture"] if exposure else []
        open_share = _mean_open(images)
        is_near = chosen.method in ("ssdo", "bounce")
        if is_near and self.scene.environment is None and open_share > MOSTLY:
            notes.append(
                f"{open_share:.0%} of the directions are open within R = {chosen.radius:.3g} and no"
                " sky is there: light from beyond it is missing; method gi has it"
            )
        return tuple(notes)

    @property
    def _slack(self) -> float | None:
        """Of the exposure, where it is still left to the picture."""
        is_known = self.scene.is_metered or self._has_exposure
        return None if is_known else self.scene.metering_slack

    def _at_centres(
        self, names: tuple[str, ...], camera: Camera | None, seconds: float
    ) -> dict[str, Image]:
        """Return images of geometry, of the samples through the pixels' centres alone."""
        names = tuple(name for name in names if name in GEOMETRY_AOVS)
        if not names:
            return {}
        job = self._prepare(names, camera, seconds)
        self._run(job.plan, self._frame(job.view, 0, 1), FrameLog(), False, None)
        return self._read(job, job.view)

    def time_frame(
        self,
        wanted: Iterable[str],
        *,
        camera: Camera | None = None,
        seconds: float = 0.0,
        number: int = 0,
        time_passes: bool = False,
    ) -> FrameTimes:
        """Draw one frame, leave it on the device and return what it took.

        Parameters
        ----------
        number : int
            A frame of another number than the last one computes all that depends on the
            view again; with the same number, what still holds is kept.
        """
        job = self._prepare(wanted, camera, seconds)
        log = FrameLog()
        frame = self._frame(job.view, 0, 1, number)
        self._run(job.plan, frame, log, time_passes, None)
        report = functools.partial(log.reports, job.pipeline, job.plan)
        return FrameTimes(log.frame_ms[0], log.process_ms[0], job.planning_ms, report)

    def draw(
        self,
        wanted: Iterable[str],
        *,
        camera: Camera,
        seconds: float = 0.0,
        index: int = 0,
        count: int = 1,
        time_passes: bool = False,
        progress: ProgressCallback | None = None,
    ) -> Drawing:
        """Draw one frame and leave its images on the device, for a window that shows them.

        Parameters
        ----------
        wanted : iterable of str
            AOV names or ``display``; ``depth`` is always there.
        index, count : int
            Which of `count` sub-pixel offsets, beginning again after the last. Every
            index has a sample pattern of its own.
        time_passes : bool
            Time every pass, too; on a software renderer that costs their overlap.
        progress : callable or None
            Called every few milliseconds; may draw other things, and raise to give the frame up.
        """
        job = self._prepare((*wanted, "depth"), camera, seconds, is_live=True)
        frame = self._frame(job.view, index, count, is_live=True)
        log, pauses = FrameLog(), list[float]()
        try:
            if progress is None:
                self._run(job.plan, frame, log, time_passes, None)
            else:
                self._executor.before_pass = pause = self._pause(progress, pauses)
                with self._bands.pausing(pause):
                    self._run(job.plan, frame, log, time_passes, progress)
            job.check_whole()
        except BaseException:
            # What is averaged over frames begins anew.
            self._drawn = ()
            raise
        finally:
            self._executor.before_pass = None
        return Drawing(
            {name: self._plane(job, name) for name in job.names},
            frame.view,
            functools.partial(log.reports, job.pipeline, job.plan),
            job.pipeline.decided.rows,
            log.frame_ms[0] - 1e3 * sum(pauses),
            job.references(),
            self._executor.is_settled,
        )

    def _pause(self, progress: ProgressCallback, pauses: list[float]) -> Callable[[], None]:
        def pause() -> None:
            # On a software renderer the work of a pass is done while one waits for it.
            self.device.gl.finish()
            start = time.perf_counter()
            progress("pass", 0, 0)
            pauses.append(time.perf_counter() - start)

        return pause

    def _read(self, job: FrameJob, view: FrameView) -> dict[str, Image]:
        width, height = self.settings.size
        images: dict[str, Image] = {}
        # Several images may lie in one texture.
        read = functools.cache(read_texture)
        for name in job.names:
            plane = self._plane(job, name)
            if plane.texture is None:
                shape = (height, width, plane.channels)
                images[name] = np.full(shape, plane.neutral, dtype=np.float32)
            else:
                first = plane.first_channel
                images[name] = read(plane.texture)[:, :, first : first + plane.channels]
            if name == "beauty":
                images[name] = self._before_background(images[name])
            elif name == "position_ws":
                images[name] = world_positions(images[name], view)
            elif name == "depth":
                images[name] = camera_depths(images[name], view)
            elif name == "normal_ws":
                z_vs = read(self._executor.texture("z_vs"))
                images[name] = world_normals(images[name], z_vs, view)
        return images

    def _before_background(self, beauty: Image) -> Image:
        """Return the picture in front of a background of one colour, as it is shown, or none."""
        color = background_color(self.settings.background)
        if self.settings.background is None:
            radiance = self.scene.backdrop
        elif color is not None:
            level = 2.0 ** -(self.settings.exposure or 0.0)
            radiance = color[0] * level, color[1] * level, color[2] * level
        else:
            radiance = None
        if radiance is None:
            return beauty
        behind = np.array([*radiance, 0.0], dtype=np.float32)
        return np.where(beauty[..., 3:] > 0.0, beauty, behind)


def _mean_open(images: Mapping[str, Image]) -> float:
    """Return the share of the hemisphere that is open within R, mean over what is seen."""
    seen = images["visibility"][..., 0][images["beauty"][..., 3] > 0.0]
    return float(seen.mean()) if len(seen) else 0.0


def render(
    source: str | Path | Scene,
    *,
    camera: Camera | str | int | None = None,
    aov: str = "beauty",
    backend: str = "auto",
    **settings: Any,
) -> Image:
    """Render one image of a scene and return it.

    Parameters
    ----------
    source : str, Path or Scene
        A scene file, a model file, the name of a built-in scene, or a Scene.
    camera : Camera, str or int, optional
        Replaces the scene's camera. Of a model file also the name or number of one of its
        cameras, and ``fit`` frames the whole scene.
    aov : str
        What to return (`ssdo_gl.settings.AOVS`, or ``display``).
    **settings
        Fields of `Settings`, e.g. ``size=(1280, 720), method="bounce"``, and of
        `LoadOptions` for what is loaded, e.g. ``light="studio"``.

    Returns
    -------
    ndarray, shape (height, width, channels), float32
        Scene-linear, row 0 at the top. ``beauty`` has four channels; the fourth is
        coverage, 0 where no surface was hit.

    Raises
    ------
    SceneError, SettingError, ContextError

    Examples
    --------
    >>> import ssdo_gl
    >>> ssdo_gl.render("corner", size=(64, 36), method="direct").shape
    (36, 64, 4)
    """
    scene, place, chosen = asked_scene(source, camera, settings)
    with Renderer(scene, chosen, backend=backend) as renderer:
        return renderer.render([aov], camera=place).whole().images[aov]
