"""Renders frames of one scene: the program's Python interface."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.gpu.geometry import Eye, Geometry
from ssdo_gl.gpu.readback import read_texture
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.gpu.timer import Timer
from ssdo_gl.graph.execute import Executor
from ssdo_gl.graph.frame import Frame, FrameView
from ssdo_gl.graph.graph import Plan
from ssdo_gl.graph.render_pass import ProgressCallback
from ssdo_gl.images.average import ImageAverage
from ssdo_gl.images.surface_arrays import world_normals, world_positions
from ssdo_gl.planning.planner import FramePlan, Planner
from ssdo_gl.planning.walk import Pipeline
from ssdo_gl.render_result import FrameLog, FrameTimes, Image, RenderResult
from ssdo_gl.scene.animate import scene_at
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.resolve import resolved, settings_for


class Renderer:
    """Renders frames of one scene on a device of its own.

    Use it as a context manager; the device is released at the end. A renderer works in the
    thread that has made it, and raises RuntimeError in others, in a forked process, and
    once it was released.

    Parameters
    ----------
    scene : Scene
    settings : Settings
        Fields that were not given yield to the scene's own wishes (``Scene.render``), as
        flags of the command line do.
    backend : str
        auto, egl, osmesa or window.
    device : Device or None
        An existing device to draw with; it is not released at the end.
    shaders : ShaderLibrary or None
        Of that device, so that several renderers compile each program once.

    Examples
    --------
    >>> from ssdo_gl import Renderer, Settings, load_scene
    >>> with Renderer(load_scene("corner"), Settings(size=(64, 36))) as renderer:
    ...     images = renderer.render(["beauty", "visibility"]).images
    >>> images["beauty"].shape, images["visibility"].shape
    ((36, 64, 4), (36, 64, 1))
    """

    def __init__(
        self,
        scene: Scene,
        settings: Settings | None = None,
        *,
        backend: str = "auto",
        device: Device | None = None,
        shaders: ShaderLibrary | None = None,
    ) -> None:
        self.scene = scene
        self.settings = resolved(settings or Settings(), scene)
        self._owns_device = device is None
        self._is_released = False
        self.device = device or create_context(backend)
        self._activate()
        self._shaders = shaders or ShaderLibrary(self.device.gl)
        self._executor = Executor(self.device, self._shaders)
        self._geometry = Geometry(self.device.gl, scene)
        self._geometry_scene = scene
        self._planner = Planner()
        self._planned: FramePlan | None = None
        self._lean = scene
        self._moved: tuple[Scene, float, Scene] | None = None
        self._versions = {"geometry": 0, "lights": 0, "environment": 0}

    @property
    def shaders(self) -> ShaderLibrary:
        """Compiled programs, to be shared with other renderers of the same device."""
        return self._shaders

    @property
    def timer(self) -> Timer:
        """What times passes."""
        return self._executor.timer

    @property
    def timer_kind(self) -> str:
        """How passes are timed: ``gl_query`` or ``finish_wall``."""
        return self.timer.kind

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.release()

    def release(self) -> None:
        """Free everything on the device; a second call does nothing."""
        if self._is_released:
            return
        self.device.activate()
        self._is_released = True
        self._executor.release()
        self._geometry.release()
        if self._owns_device:
            self.device.release()

    def _activate(self) -> None:
        """Make the device current: another one may have been made, or used, since."""
        if self._is_released:
            raise RuntimeError("this renderer was released; make another one")
        self.device.activate()

    def use(self, settings: Settings) -> None:
        """Render with other settings from now on; what they leave alone stays warm."""
        self._activate()
        self.settings = resolved(settings, self.scene)

    def use_scene(self, scene: Scene) -> None:
        """Render another scene from now on, or this one after a change.

        A scene that shares meshes, lights or environment with the one before keeps what
        was made from them. The settings stay as they are.
        """
        self.scene = scene

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
            Frames that are timed. With more than one, a warm-up frame comes first
            and every frame recomputes all that depends on the view.
        time_passes : bool
            Time every pass, too.
        """
        self._activate()
        names = tuple(dict.fromkeys(wanted))
        self._follow(self._scene_at(seconds))
        view = self._view(camera or self.scene.camera)
        pipeline, plan = self._plan(names, view)
        count, partial = self.settings.antialias, False
        log = FrameLog()
        average = ImageAverage()
        for index in range(count):
            frame = self._frame(view, index, count)
            self._run(plan, frame, log, time_passes, progress)
            average.add(self._read(pipeline, names, frame.view))
            partial = any(item.statistics.get("partial") for item in plan.order)
            if partial:
                break
            if progress is not None and count > 1:
                progress("anti-aliasing frames", index + 1, count)
        if frames > 1 and not partial:
            log.restart()
            for number in range(frames):
                frame = self._frame(view, 0, count, number + 1)
                self._run(plan, frame, log, time_passes, progress)
        return RenderResult(
            images=average.images(),
            size=self.settings.size,
            settings=self.settings,
            passes=log.reports(pipeline, plan),
            decisions=pipeline.decided.rows,
            frame_ms=log.frame_ms,
            setup_ms=log.setup_ms or 0.0,
            process_ms=log.process_ms,
            references={item.name: dict(item.statistics) for item in plan.order if item.statistics},
            partial=partial,
        )

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
        self._activate()
        self._follow(self._scene_at(seconds))
        names = tuple(dict.fromkeys(wanted))
        view = self._view(camera or self.scene.camera)
        start = time.perf_counter()
        pipeline, plan = self._plan(names, view)
        planning_ms = (time.perf_counter() - start) * 1e3
        log = FrameLog()
        self._run(plan, self._frame(view, 0, 1, number), log, time_passes, None)
        reports = log.reports(pipeline, plan)
        return FrameTimes(log.frame_ms[0], log.process_ms[0], planning_ms, reports)

    def _run(
        self,
        plan: Plan,
        frame: Frame,
        log: FrameLog,
        time_passes: bool,
        progress: ProgressCallback | None,
    ) -> None:
        """Run one frame to its end and record what it took."""
        start, process_start = time.perf_counter(), time.process_time()
        rows = self._executor.run(
            plan, frame, self._geometry, time_passes=time_passes, progress=progress
        )
        self.device.gl.finish()
        log.add(
            (time.perf_counter() - start) * 1e3, (time.process_time() - process_start) * 1e3, rows
        )

    def _scene_at(self, seconds: float) -> Scene:
        """Return the scene at a time: the very same as last time while time stands still."""
        if self._moved is None or self._moved[:2] != (self.scene, seconds):
            self._moved = (self.scene, seconds, scene_at(self.scene, seconds))
        return self._moved[2]

    def _follow(self, scene: Scene) -> None:
        """Bring the device's geometry to the state of `scene`."""
        before, self._geometry_scene = self._geometry_scene, scene
        parts = ((s.objects, s.materials, s.meshes) for s in (before, scene))
        if scene is not before and not all(map(_is_same, *parts)):
            self._geometry.update(scene)
            self._versions["geometry"] += 1

    def _plan(self, names: tuple[str, ...], view: FrameView | None = None) -> tuple[Pipeline, Plan]:
        """Return what a frame of the scene as it stands has to run."""
        moved = self._geometry_scene
        self._planned = self._planner.plan(self.scene, moved, self.settings, names, view)
        lean = self._planned.scene
        if lean is not self._lean:
            self._versions["lights"] += not _is_same(lean.lights, self._lean.lights)
            self._versions["environment"] += lean.environment != self._lean.environment
            self._lean = lean
        return self._planned.pipeline, self._planned.graph

    def _view(self, camera: Camera) -> FrameView:
        """Return the view through the pixels' centres of the geometry as it stands."""
        size = self.settings.size
        rotation = camera.view_from_world_rotation()
        position = np.asarray(camera.position, dtype=np.float64)
        tan_half_fov = camera.tan_half_fov(size[0] / size[1])
        near, far = self._geometry.near_far(Eye(position, rotation), tan_half_fov)
        return FrameView(
            size=size,
            position_ws=position,
            view_from_world=rotation,
            tan_half_fov=tan_half_fov,
            near=near,
            far=far,
        )

    def _frame(self, view: FrameView, index: int, count: int, nonce: int = 0) -> Frame:
        """Return frame `index` of `count` of what was planned last.

        Another `nonce` makes anew what depends on the view.
        """
        view = dataclasses.replace(view, jitter_px=jitter(index, count))
        seed = self.settings.seed + index
        versions = {**self._versions, "view": (view.key(), nonce), "seed": seed}
        return Frame(view=view, scene=self._lean, seed=seed, versions=versions)

    def _read(
        self, pipeline: Pipeline, names: tuple[str, ...], view: FrameView
    ) -> dict[str, Image]:
        width, height = self.settings.size
        images: dict[str, Image] = {}
        for name in names:
            source = pipeline.outputs[name]
            if source.resource is None:
                shape = (height, width, source.channels)
                images[name] = np.full(shape, source.neutral, dtype=np.float32)
            else:
                array = read_texture(self._executor.texture(source.resource))
                first = source.first_channel
                images[name] = array[:, :, first : first + source.channels]
            if name == "position_ws":
                images[name] = world_positions(images[name], view)
            elif name == "normal_ws":
                z_vs = read_texture(self._executor.texture("z_vs"))
                images[name] = world_normals(images[name], z_vs, view)
        return images


def _is_same(a: Sequence[object], b: Sequence[object]) -> bool:
    """Return whether two sequences hold the very same objects."""
    return len(a) == len(b) and all(x is y for x, y in zip(a, b, strict=True))


def jitter(index: int, count: int) -> tuple[float, float]:
    """Return the sub-pixel offset of frame `index` of `count`, in pixels.

    A rank-1 lattice of the golden ratio: each of `count` columns and, nearly, rows of
    the pixel is met once. Its mean is exactly the pixel centre, where a single frame
    samples; otherwise averaging frames would shift the picture.
    """
    golden = 0.6180339887498949
    y_of = [(golden * number) % 1.0 for number in range(count)]
    return (index + 0.5) / count - 0.5, y_of[index] - sum(y_of) / count


def render(
    source: str | Path | Scene, *, aov: str = "beauty", backend: str = "auto", **settings: Any
) -> Image:
    """Render one image of a scene and return it.

    Parameters
    ----------
    source : str, Path or Scene
        A scene file, a model file, the name of a built-in scene, or a Scene.
    aov : str
        What to return (`ssdo_gl.settings.AOVS`, or ``display``).
    **settings
        Fields of `Settings`, e.g. ``size=(1280, 720), method="bounce"``.

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
    scene = source if isinstance(source, Scene) else load_scene(source)
    mapping: Mapping[str, Any] = settings
    with Renderer(scene, settings_for(scene.render, mapping), backend=backend) as renderer:
        return renderer.render([aov]).images[aov]
