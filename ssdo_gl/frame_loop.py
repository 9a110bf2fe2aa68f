"""Plans and runs frames of one scene on one device: what every way to render shares."""

from __future__ import annotations

import time
from collections.abc import Hashable, Iterable
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.gpu.fullscreen import DrawBands
from ssdo_gl.gpu.geometry import CLIP_MARGIN, CameraPose
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.gpu.timer import Timer
from ssdo_gl.graph.execute import Executor
from ssdo_gl.graph.frame import Frame, FrameView
from ssdo_gl.graph.graph import Plan
from ssdo_gl.graph.render_pass import ProgressCallback
from ssdo_gl.image_requests import checked_camera, checked_images
from ssdo_gl.images.average import jitter
from ssdo_gl.last_made import LastMade
from ssdo_gl.options.resolve import resolved, with_scene_settings
from ssdo_gl.passes.temporal import TemporalPass
from ssdo_gl.planning.pipeline import Pipeline
from ssdo_gl.planning.planner import FramePlan, Planner
from ssdo_gl.render_result import FrameLog, Plane
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.numbers import check_number
from ssdo_gl.scene.scene import Scene, check_scene
from ssdo_gl.scene.scene_error import check_type
from ssdo_gl.settings import Settings
from ssdo_gl.settings.backgrounds import TRANSPARENT
from ssdo_gl.shared_scene import SharedScene


@dataclass(frozen=True)
class FrameJob:
    """A frame that was planned: which images, of which view, by which passes."""

    names: tuple[str, ...]
    camera: Camera
    view: FrameView
    pipeline: Pipeline
    plan: Plan
    planning_ms: float

    def references(self) -> dict[str, Any]:
        """Return the statistics of the Monte-Carlo passes."""
        return {item.name: dict(item.statistics) for item in self.plan.order if item.statistics}

    @property
    def is_partial(self) -> bool:
        """Whether one of them was interrupted in the last frame."""
        return any(item.statistics.get("partial") for item in self.plan.order)

    def check_whole(self) -> None:
        """Raise the KeyboardInterrupt that one of them took for the end of its rays."""
        if self.is_partial:
            raise KeyboardInterrupt


class FrameLoop:
    """A scene, the device it is drawn with, and everything that is kept between frames.

    Parameters are those of `Renderer`.
    """

    def __init__(
        self,
        scene: Scene,
        settings: Settings | None = None,
        *,
        backend: str = "auto",
        device: Device | None = None,
        shaders: ShaderLibrary | None = None,
        shared: SharedScene | None = None,
    ) -> None:
        check_scene(scene)
        self.scene, self.settings = scene, settings or Settings()
        check_type("settings", self.settings, Settings)
        self._resolve(self.settings)
        self._owns_device = device is None
        self._is_released = False
        self.device = device or create_context(backend)
        self._activate()
        self._shaders = shaders or ShaderLibrary(self.device.gl, computes=self.device.computes)
        self._owns_shared = shared is None
        self._bare: LastMade[Scene] = LastMade()
        scene = self._shown
        self._shared = shared or SharedScene(self.device.gl, scene)
        self._executor = Executor(self.device, self._shaders, self._shared.results)
        self._bands = DrawBands(self.device.gl)
        self._geometry = self._shared.geometry
        self._geometry_scene = scene
        self._planner = Planner()
        self._planned: FramePlan | None = None
        self._lean = scene
        self._checked: dict[tuple[str, ...], tuple[str, ...]] = {}
        self._pose: tuple[Camera, CameraPose] | None = None
        self._looked: tuple[Hashable, FrameView] | None = None
        self._moved: tuple[Scene, float, Scene] | None = None
        self._versions = self._shared.follow(scene) | self._light_versions(scene)
        self._drawn: tuple[object, ...] = ()
        self._moves = self._view_moves = 0

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

    def __exit__(self, *fault: object) -> None:
        self.release()

    def release(self) -> None:
        """Free everything on the device; a second call does nothing."""
        if self._is_released:
            return
        self.device.activate()
        self._is_released = True
        self._executor.release()
        # Passes have textures, too, to work in.
        self._planner, self._planned = Planner(), None
        if self._owns_shared:
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
        self._resolve(settings)

    def _resolve(self, settings: Settings) -> None:
        """Take over settings; what was not given comes from the scene."""
        self._has_exposure = with_scene_settings(settings, self.scene.render).gives("exposure")
        self.settings = resolved(settings, self.scene)

    def use_scene(self, scene: Scene) -> None:
        """Render another scene from now on, or this one after a change.

        A scene that shares meshes, lights or environment with the one before keeps what
        was made from them. The settings stay as they are.

        Raises
        ------
        SceneError
            Naming a part that cannot be drawn.
        """
        check_scene(scene)
        self.scene = scene

    def forget(self) -> None:
        """Run every pass again in the next frame: its shader may have changed."""
        self._executor.forget()
        self._drawn = ()

    def _prepare(
        self,
        wanted: Iterable[str],
        camera: Camera | None,
        seconds: float,
        *,
        is_live: bool = False,
    ) -> FrameJob:
        """Bring scene and geometry to their state at `seconds`, and plan a frame of it."""
        self._activate()
        names = self._checked_images(wanted)
        checked_camera(camera)
        check_number("seconds", seconds)
        self._follow(self._scene_at(seconds))
        camera = camera or self._geometry_scene.camera
        view = self._view(camera)
        start = time.perf_counter()
        pipeline, plan = self._plan(names, view, is_live)
        return FrameJob(names, camera, view, pipeline, plan, (time.perf_counter() - start) * 1e3)

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

    def _checked_images(self, wanted: Iterable[str]) -> tuple[str, ...]:
        """Return the images that are asked for, whose names were checked the first time."""
        if isinstance(wanted, str) or not hasattr(wanted, "__iter__"):
            return checked_images(wanted)
        asked = tuple(wanted)
        try:
            return self._checked[asked]
        except (KeyError, TypeError):  # TypeError: what has no hash is no name, either
            return self._checked.setdefault(asked, checked_images(asked))

    @property
    def _shown(self) -> Scene:
        """What is drawn of the scene: no ground under a cut-out."""
        if self.settings.background != TRANSPARENT:
            return self.scene
        return self._bare.get((self.scene,), self.scene.without_ground)

    def _scene_at(self, seconds: float) -> Scene:
        """Return the scene at a time: the very same as last time while time stands still."""
        scene = self._shown
        if self._moved is None or self._moved[:2] != (scene, seconds):
            self._moved = (scene, seconds, self._shared.at(scene, seconds))
        return self._moved[2]

    def _follow(self, scene: Scene) -> None:
        """Bring the device's geometry to the state of `scene`."""
        self._geometry_scene = scene
        self._versions |= self._shared.follow(scene)

    def _plan(
        self, names: tuple[str, ...], view: FrameView | None = None, is_live: bool = False
    ) -> tuple[Pipeline, Plan]:
        """Return what a frame of the scene as it stands has to run."""
        moved = self._geometry_scene
        self._planned = self._planner.plan(
            self._shown, moved, self.settings, names, view, is_live=is_live
        )
        lean = self._planned.scene
        if lean is not self._lean:
            self._versions |= self._light_versions(lean)
            self._lean = lean
        return self._planned.pipeline, self._planned.graph

    def _light_versions(self, lean: Scene) -> dict[str, int]:
        """Return those of lights as they stand, and of lights wherever an animation moves them."""
        sources = self._shared.light_versions(self._shown)["lights"]
        return {**self._shared.light_versions(lean), "light_sources": sources}

    def _view(self, camera: Camera) -> FrameView:
        """Return the view through the pixels' centres of the geometry as it stands."""
        size = self.settings.size
        state = camera, size, self._versions["geometry"]
        if self._looked is None or self._looked[0] != state:
            self._looked = state, self._new_view(camera, size)
        return self._looked[1]

    def _new_view(self, camera: Camera, size: tuple[int, int]) -> FrameView:
        aspect = size[0] / size[1]
        if self._pose is None or self._pose[0] != camera:
            rotation = camera.view_from_world_rotation()
            pose = CameraPose(np.asarray(camera.position, dtype=np.float64), rotation)
            self._pose = camera, pose
        pose = self._pose[1]
        if camera.height is not None:
            bounds = self._geometry.depth_bounds(pose, camera.half_frame(aspect))
            return parallel_view(pose, size, camera.half_frame(aspect), bounds)
        tan_half_fov = camera.tan_half_fov(aspect)
        near, far = self._geometry.near_far(pose, tan_half_fov)
        return FrameView(size, pose.position_ws, pose.view_from_world, tan_half_fov, near, far)

    def _frame(
        self, view: FrameView, index: int, count: int, nonce: int = 0, *, is_live: bool = False
    ) -> Frame:
        """Return frame `index` of `count` of what was planned last.

        Another `nonce` makes anew what depends on the view. Live frames may leave work to
        those that follow.
        """
        first_seed, moves = self.settings.seed, self._count_move(view) if is_live else 0
        seed, steady_view = first_seed + index, (view.key(), nonce, count, is_live)
        if count > 1:
            view = view.jittered(jitter(index % count, count))
        versions = {
            **self._versions,
            "view": (view.key(), nonce),
            "seed": (seed, moves),
            "steady_view": steady_view,
            "steady_seed": (first_seed, moves),
        }
        planned = self._planned
        return Frame(
            *(view, self._lean, seed, versions, is_live, first_seed, count, moves),
            view_moves=self._view_moves,
            gloss_region=None if planned is None else planned.gloss_region,
            emission_region=None if planned is None else planned.emission_region,
        )

    def _count_move(self, view: FrameView) -> int:
        """Return the number of a frame that shows the scene of the one before, moved; else 0."""
        assert self._planned is not None
        passes = (item for item in self._planned.graph.order if type(item) is TemporalPass)
        if (average := next(passes, None)) is None:
            return 0
        light = tuple(self._versions[n] for n in ("materials", "environment", average.lit_by))
        kept = light, view.size, view.tan_half_fov, view.half_frame
        last, self._drawn = self._drawn, (kept, self._versions["geometry"], view.key())
        if not last or last[0] != kept or last == self._drawn:
            return 0
        self._moves += 1
        self._view_moves += last[2] != view.key()
        return self._moves

    def _plane(self, job: FrameJob, name: str) -> Plane:
        """Return where an image of the frame that was run last lies."""
        output = job.pipeline.outputs[name]
        texture = None if output.resource is None else self._executor.texture(output.resource)
        return Plane(texture, output.first_channel, output.channels, output.neutral)


def parallel_view(
    pose: CameraPose,
    size: tuple[int, int],
    half_frame: tuple[float, float],
    bounds: tuple[float, float] | None,
) -> FrameView:
    """Return the view of parallel rays that begin in the plane of `pose`.

    Parameters
    ----------
    bounds : (float, float) or None
        Between which depths from there everything lies that can be seen.
    """
    nearest, farthest = bounds or (0.0, 1.0)
    begin = max(nearest, 0.0)
    ahead = -pose.view_from_world[2]
    room = 2.0 * half_frame[1]
    # Boxes may be off by rounding; what begins at the camera's plane is cut off there.
    margin = CLIP_MARGIN * room if nearest > 0.0 else 0.0
    return FrameView(
        size=size,
        position_ws=pose.position_ws + ahead * (begin - room),
        view_from_world=pose.view_from_world,
        tan_half_fov=(0.0, 0.0),
        near=room - margin,
        far=(room + farthest - begin) * (1.0 + CLIP_MARGIN),
        half_frame=half_frame,
        depth_offset=begin - room,
    )
