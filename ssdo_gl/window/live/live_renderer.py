"""A renderer whose images stay on the device, for a window that shows them at once."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import moderngl

from ssdo_gl.effects.decisions import Decision
from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.graph.frame import FrameView
from ssdo_gl.graph.render_pass import ProgressCallback
from ssdo_gl.render_result import FrameLog, PassReport
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings


@dataclass(frozen=True)
class Plane:
    """An image on the device: channels of a texture, or one number everywhere.

    Attributes
    ----------
    texture : moderngl.Texture or None
        The renderer's; it holds until the next frame is drawn.
    first_channel : int
    neutral : float
        What every channel is if there is no texture.
    """

    texture: moderngl.Texture | None
    first_channel: int = 0
    neutral: float = 0.0


@dataclass(frozen=True)
class Drawing:
    """One frame that was drawn.

    Attributes
    ----------
    planes : mapping of image name to Plane
    view : FrameView
    passes : tuple of PassReport
    decisions : tuple of Decision
    frame_ms : float
        Until the device had finished.
    references : mapping
        Statistics of the Monte-Carlo passes.
    """

    planes: Mapping[str, Plane]
    view: FrameView
    passes: tuple[PassReport, ...]
    decisions: tuple[Decision, ...]
    frame_ms: float
    references: Mapping[str, Any] = field(default_factory=dict)


class LiveRenderer(Renderer):
    """Renders one frame at a time and leaves it on the device.

    Parameters
    ----------
    scene : Scene
    settings : Settings
    device : Device
        Of the window; it is not released.
    shaders : ShaderLibrary
        Shared by all renderers of the window, so that each program is compiled once.
    """

    def __init__(
        self, scene: Scene, settings: Settings, *, device: Device, shaders: ShaderLibrary
    ) -> None:
        super().__init__(scene, settings, device=device, shaders=shaders)

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
        """Draw one frame.

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
            Called between passes, and within long ones; may raise to give the frame up.
        """
        self._activate()
        names = tuple(dict.fromkeys((*wanted, "depth")))
        self._follow(self._scene_at(seconds))
        view = self._view(camera)
        pipeline, plan = self._plan(names, view)
        frame = self._frame(view, index % count, count)
        seed = self.settings.seed + index
        frame = dataclasses.replace(frame, seed=seed, versions={**frame.versions, "seed": seed})
        log = FrameLog()
        self._executor.before_pass = None if progress is None else self._pause(progress)
        try:
            self._run(plan, frame, log, time_passes, progress)
        except BaseException:
            # What was interrupted is neither what it was nor what it should become.
            self.forget()
            raise
        planes = {}
        for name in names:
            output = pipeline.outputs[name]
            texture = None if output.resource is None else self._executor.texture(output.resource)
            planes[name] = Plane(texture, output.first_channel, output.neutral)
        return Drawing(
            planes,
            frame.view,
            log.reports(pipeline, plan),
            pipeline.decided.rows,
            log.frame_ms[0],
            {item.name: dict(item.statistics) for item in plan.order if item.statistics},
        )

    def _pause(self, progress: ProgressCallback) -> Callable[[], None]:
        def pause() -> None:
            # On a software renderer the work of a pass is done while one waits for it.
            self.device.gl.finish()
            progress("pass", 0, 0)

        return pause

    def show(self, scene: Scene, settings: Settings) -> None:
        """Render `scene` from now on: the same with other lights, or quite another."""
        self.use_scene(scene)
        self.use(settings)

    def forget(self) -> None:
        """Run every pass again in the next frame: its shader may have changed."""
        self._executor.forget()
