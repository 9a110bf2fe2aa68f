"""Renders frames of one scene: the program's Python interface."""

from __future__ import annotations

import dataclasses
import statistics
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.effects import Decision
from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.gpu.geometry import Eye, Geometry
from ssdo_gl.gpu.readback import read_texture
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.graph.execute import Executor, PassTiming
from ssdo_gl.graph.frame import Frame, FrameView
from ssdo_gl.graph.graph import Plan, compile_graph
from ssdo_gl.graph.render_pass import ProgressCallback
from ssdo_gl.options import settings_for
from ssdo_gl.pipelines import Pipeline, build_pipeline
from ssdo_gl.scene.animate import scene_at
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.content import analyse
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.surface_arrays import world_normals, world_positions

Image = NDArray[np.float32]


@dataclass(frozen=True)
class PassReport:
    """What one pass did, for ``--explain`` and ``--stats``."""

    name: str
    ran: bool
    reason: str
    gpu_ms: float | None = None
    cpu_ms: float = 0.0


@dataclass(frozen=True)
class RenderResult:
    """The outcome of `Renderer.render`.

    Attributes
    ----------
    images : dict of str to ndarray, shape (height, width, channels), float32
        Row 0 at the top.
    passes : tuple of PassReport
        Medians over the timed frames.
    frame_ms : tuple of float
        Milliseconds of each timed frame until the device had finished.
    process_ms : tuple of float
        Processor time of the same frames, all threads: what a software rasterizer
        spends, whatever else the machine is doing.
    setup_ms : float
        The first frame, with shader compilation, shadow maps and uploads.
    references : dict
        Statistics of the Monte-Carlo passes: samples per pixel, standard errors.
    """

    images: dict[str, Image]
    size: tuple[int, int]
    settings: Settings
    passes: tuple[PassReport, ...]
    decisions: tuple[Decision, ...]
    frame_ms: tuple[float, ...]
    setup_ms: float
    process_ms: tuple[float, ...] = ()
    references: dict[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def frame_summary(self) -> dict[str, float]:
        """Return median, min and max of the frame times, milliseconds."""
        times = self.frame_ms
        values = {"median": statistics.median(times), "min": min(times), "max": max(times)}
        return {name: round(value, 3) for name, value in values.items()}


class Renderer:
    """Renders frames of one scene on a device of its own.

    Use it as a context manager; the device is released at the end.

    Parameters
    ----------
    scene : Scene
    settings : Settings
    backend : str
        auto, egl, osmesa or window.
    device : Device or None
        An existing device to draw with; it is not released at the end.

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
    ) -> None:
        self.scene = scene
        self.settings = self._completed(settings or settings_for(scene.render, {}))
        self._owns_device = device is None
        self.device = device or create_context(backend)
        self._shaders = ShaderLibrary(self.device.gl)
        self._executor = Executor(self.device, self._shaders)
        self._geometry = Geometry(self.device.gl, scene)
        self._content = analyse(scene)
        self._scene_version = 0
        self._geometry_scene = scene
        self._plans: dict[Any, tuple[Pipeline, Plan]] = {}

    @property
    def timer_kind(self) -> str:
        """How passes are timed: ``gl_query`` or ``finish_wall``."""
        return self._executor.timer.kind

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
        """Free everything on the device."""
        self._executor.release()
        self._geometry.release()
        if self._owns_device:
            self.device.release()

    def use(self, settings: Settings) -> None:
        """Render with other settings from now on; what they leave alone stays warm."""
        self.settings = self._completed(settings)
        self._plans.clear()

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
        names = tuple(dict.fromkeys(wanted))
        camera = camera or self.scene.camera
        moved = scene_at(self.scene, seconds)
        self._follow(moved)
        pipeline, plan = self._plan(names)
        count = self.settings.antialias
        sums: dict[str, NDArray[np.float64]] = {}
        times: list[float] = []
        process_times: list[float] = []
        timings: list[list[PassTiming]] = []
        setup_ms = 0.0

        def run_frame(index: int, nonce: int) -> list[PassTiming]:
            nonlocal setup_ms
            frame = self._frame(moved, camera, index, count, nonce)
            start, process_start = time.perf_counter(), time.process_time()
            rows = self._executor.run(
                plan, frame, self._geometry, time_passes=time_passes, progress=progress
            )
            self.device.gl.finish()
            elapsed = (time.perf_counter() - start) * 1e3
            if not times and not setup_ms:
                setup_ms = elapsed
            else:
                times.append(elapsed)
                process_times.append((time.process_time() - process_start) * 1e3)
                timings.append(rows)
            if not timings:
                timings.append(rows)
            return rows

        for index in range(count):
            run_frame(index, 0)
            view = self._frame(moved, camera, index, count, 0).view
            for name, array in self._read(pipeline, names, view).items():
                sums[name] = sums.get(name, 0.0) + array.astype(np.float64)
            if progress is not None and count > 1:
                progress("anti-aliasing frames", index + 1, count)
        if frames > 1:
            times.clear()
            process_times.clear()
            timings.clear()
            for number in range(frames):
                run_frame(0, number + 1)
        images = {name: (array / count).astype(np.float32) for name, array in sums.items()}
        return RenderResult(
            images=images,
            size=self.settings.size,
            settings=self.settings,
            passes=self._reports(pipeline, plan, timings),
            decisions=pipeline.decisions,
            frame_ms=tuple(times) or (setup_ms,),
            setup_ms=setup_ms,
            process_ms=tuple(process_times),
            references={item.name: dict(item.statistics) for item in plan.order if item.statistics},
            notes=pipeline.notes,
        )

    def _completed(self, settings: Settings) -> Settings:
        """Return `settings` with what the scene decides filled in."""
        radius = settings.radius
        if radius is None:
            radius = float(self.scene.render.get("radius") or self.scene.default_radius())
        exposure = settings.exposure
        if exposure is None:
            exposure = self.scene.camera.exposure
        return dataclasses.replace(settings, radius=radius, exposure=exposure).checked()

    def _follow(self, scene: Scene) -> None:
        """Bring the device's geometry to the state of `scene`."""
        if scene is not self._geometry_scene:
            self._geometry.update(scene)
            self._geometry_scene = scene
            self._scene_version += 1

    def _plan(self, names: tuple[str, ...]) -> tuple[Pipeline, Plan]:
        key = (names, self.settings.method)
        if key not in self._plans:
            pipeline = build_pipeline(self._geometry_scene, self._content, self.settings, names)
            self._plans[key] = pipeline, compile_graph(pipeline.passes, pipeline.resources)
        return self._plans[key]

    def _frame(self, scene: Scene, camera: Camera, index: int, count: int, nonce: int) -> Frame:
        size = self.settings.size
        rotation = camera.view_from_world_rotation()
        position = np.asarray(camera.position, dtype=np.float64)
        tan_half_fov = camera.tan_half_fov(size[0] / size[1])
        near, far = self._geometry.near_far(Eye(position, rotation), tan_half_fov)
        view = FrameView(
            size=size,
            position_ws=position,
            view_from_world=rotation,
            tan_half_fov=tan_half_fov,
            near=near,
            far=far,
            jitter_px=jitter(index, count),
        )
        seed = self.settings.seed + index
        versions = {
            "view": (view.key(), nonce),
            "geometry": self._scene_version,
            "lights": self._scene_version,
            "environment": 0,
            "seed": seed,
        }
        return Frame(view=view, scene=scene, seed=seed, versions=versions)

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

    @staticmethod
    def _reports(
        pipeline: Pipeline, plan: Plan, timings: list[list[PassTiming]]
    ) -> tuple[PassReport, ...]:
        by_name: dict[str, list[PassTiming]] = {}
        for rows in timings:
            for row in rows:
                by_name.setdefault(row.name, []).append(row)
        reports = []
        for item in plan.order:
            ran = [row for row in by_name[item.name] if row.ran]
            reason = pipeline.reasons.get(item.name, "needed for what was asked")
            if not ran:
                reports.append(PassReport(item.name, False, f"unchanged, kept: {reason}"))
                continue
            measured = [row.gpu_ms for row in ran if row.gpu_ms is not None]
            reports.append(
                PassReport(
                    item.name,
                    True,
                    reason,
                    statistics.median(measured) if measured else None,
                    statistics.median(row.cpu_ms for row in ran),
                )
            )
        for item in plan.culled:
            reports.append(PassReport(item.name, False, "nothing that was asked for reads it"))
        for name, reason in pipeline.skipped.items():
            reports.append(PassReport(name, False, reason))
        return tuple(reports)


def jitter(index: int, count: int) -> tuple[float, float]:
    """Return the sub-pixel offset of frame `index` of `count`, pixels, within +-1/2.

    A single frame samples the pixel centre. Otherwise the R2 sequence (Roberts
    2018), whose first points cover a pixel evenly for every count.
    """
    if count == 1:
        return 0.0, 0.0
    # 1/g and 1/g^2 with g the plastic number, the root of g^3 = g + 1.
    x, y = 0.7548776662466927 * index, 0.5698402909980532 * index
    return (x + 0.5) % 1.0 - 0.5, (y + 0.5) % 1.0 - 0.5


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
