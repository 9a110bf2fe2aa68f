"""What the window shows and how it answers: everything but the window itself."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.graph.render_pass import ProgressCallback
from ssdo_gl.math3d import Vector
from ssdo_gl.render_result import Drawing
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import values
from ssdo_gl.settings.resolve import settings_for
from ssdo_gl.window.camera import Controls, direction_point
from ssdo_gl.window.chosen import Chosen
from ssdo_gl.window.exposed import exposed
from ssdo_gl.window.light_edits import with_lights
from ssdo_gl.window.live import INSPECTED, KeptPlanes, Monitor, clearance, surface_point
from ssdo_gl.window.presenter import Presenter
from ssdo_gl.window.scene_flight import SceneFlight
from ssdo_gl.window.side import Side
from ssdo_gl.window.views import View, image_of, kind_of_image, settings_of

# A frame of a 30 Hz display.
DEFAULT_BUDGET_MS = 33.0
# Frames in motion that take longer are cut into slices, too, so that the panel answers.
SLOW_MS = 50.0
# Nothing has to move for this long before full quality is worth starting: between two
# strokes of a key one does not want to wait for a frame of it.
REST_SECONDS = 0.2


class Viewer(SceneFlight, Chosen):
    """A scene, a camera in it, and one or two methods that draw it.

    Parameters
    ----------
    device : Device
        Its context is current.
    scene : Scene
    settings : Settings
        As the command line gave them; the size is the window's business.
    source : str
        The scene as it was named.
    camera : Camera or None
        Replaces the scene's; home of the flight.
    folder : Path
        Where bookmarks, pictures and films go.
    presets : mapping of name to fields of Settings
    measured : sequence of mapping
        Settings that were found best for their time, from fast to accurate.

    Attributes
    ----------
    film_suffix : str
        Which kind of film is exported, one of `film_files.FILM_SUFFIXES`.
    is_inspecting, shows_histogram, times_passes : bool
        What besides the picture has to be made for somebody who looks at it.
    monitor : Monitor
        Alarms, and the error of the left side against the right one.
    frame_ms : float
        Of the last frame, both sides together.
    can_be_given_up : bool
        Whether the frame in the making is one at rest.
    """

    _STATE = (*SceneFlight._STATE, "settings", "view")

    def __init__(
        self,
        device: Device,
        scene: Scene,
        settings: Settings,
        *,
        source: str,
        camera: Camera | None = None,
        folder: Path = Path(),
        budget_ms: float | None = DEFAULT_BUDGET_MS,
        presets: Mapping[str, Mapping[str, Any]] = MappingProxyType({}),
        measured: Sequence[Mapping[str, Any]] = (),
        shaders: ShaderLibrary | None = None,
    ) -> None:
        SceneFlight.__init__(self, folder)
        Chosen.__init__(self, settings, presets)
        self.device = device
        self.shaders = shaders or ShaderLibrary(device.gl)
        self.presenter = Presenter(device, self.shaders)
        self.measured = measured
        self.budget_ms = budget_ms or DEFAULT_BUDGET_MS
        self.is_governed = budget_ms is not None
        self.is_inspecting = False
        self.film_suffix = ".mp4" if find_spec("imageio_ffmpeg") else ".webp"
        self.shows_histogram = False
        self.times_passes = False
        self.frame_ms = 0.0
        self.monitor = Monitor(device, self.shaders)
        self._kept = KeptPlanes(device)
        self._sides: list[Side] = []
        self._shown: tuple[Any, ...] = ()
        self._begun = self.settings, self.view
        self.can_be_given_up = False
        self._still_s = 0.0
        self._last_camera: Camera | None = None
        self._last_state: object = None
        self._drawn_state: dict[str, Any] | None = None
        self._take(exposed(scene, settings, camera, device, self.shaders), source, camera)

    # --- the scene -----------------------------------------------------------------

    def open(self, scene: Scene, source: str) -> None:
        """Show another scene; what the flags asked for goes on to hold."""
        usual = values(settings_for(self.original.render, {}))
        now = values(self.settings)
        given = {name: value for name, value in now.items() if value != usual[name]}
        settings = settings_for(scene.render, given)
        before = self._state()
        try:
            scene = exposed(scene, settings, None, self.device, self.shaders)
            self._take(scene, source, None)
        except Exception:
            self._restore(before)
            raise
        self.settings = settings
        self.view = dataclasses.replace(self.view, method=settings.method)
        for side in self._sides:
            side.show(scene, settings)
        self.touch()

    def step_back(self) -> bool:
        """Return to what was drawn last, after a frame that failed; False if that is unknown.

        A second failure without a frame in between is none of what has changed.
        """
        if self._drawn_state is None:
            return False
        self._restore(self._drawn_state)
        self._drawn_state = None
        self.tour.stop()
        for side in self._sides:
            side.show(self.scene, self.settings)
        self.touch()
        return True

    def apply_lights(self) -> None:
        """Draw with `lights` and `lights_on` as they are now."""
        self.edit(with_lights(self.original, self.lights, self.lights_on))

    def edit(self, scene: Scene) -> None:
        """Draw an edited version of the same scene."""
        self.scene = scene
        for side in self._sides:
            side.show(scene, self.settings, is_new=False)
        self.touch()

    # --- what is asked for ---------------------------------------------------------

    def touch(self) -> None:
        """Note that something has changed: draw fluidly first, refine later."""
        self._still_s = 0.0

    def restart(self) -> None:
        """Draw everything anew: shaders have changed."""
        for side in self._sides:
            side.image.renderer.forget()
            side.image.restart()
        self.touch()

    @property
    def left(self) -> Side | None:
        """The side of `view.method`; None before the first frame."""
        return self._sides[0] if self._sides else None

    @property
    def right(self) -> Side | None:
        """The side of `view.other_method`, while two are compared."""
        return self._sides[1] if len(self._sides) > 1 else None

    @property
    def picture_size(self) -> tuple[int, int]:
        """Pixels of the picture that was drawn last."""
        picture = self.presenter.picture
        return self.settings.size if picture is None else picture.size

    @property
    def is_resting(self) -> bool:
        """Whether nothing has moved for a moment."""
        return self._still_s >= REST_SECONDS

    @property
    def has_drawing(self) -> bool:
        """Whether there is a frame whose depth and images can be read."""
        return self.left is not None and self.left.image.drawing is not None

    @property
    def is_busy(self) -> bool:
        """Whether another frame would change the picture without anybody's doing."""
        return bool(
            self.flight.is_moving
            or self.clock.is_running
            or self.tour.played_s is not None
            or self.tour.is_recording
            or not self._sides
            or not self.is_resting
            or not all(side.is_done for side in self._sides)
            or self.monitor.is_due
        )

    def pick(self, uv: tuple[float, float]) -> Vector | None:
        """Return the world-space point under a place of the picture, 0..1 from the top left."""
        if self.left is None or self.left.image.drawing is None:
            return None
        return surface_point(self.device.gl, self.left.image.drawing, uv)

    def point_at(self, uv: tuple[float, float]) -> Vector:
        """Return what `pick` does; where there is no surface, a point as far as the target."""
        point = self.pick(uv)
        if point is not None:
            return point
        width, height = self.picture_size
        return direction_point(self.camera, uv, width / height)

    # --- frames --------------------------------------------------------------------

    def frame(
        self,
        controls: Controls,
        seconds: float,
        size: tuple[int, int],
        progress: ProgressCallback | None = None,
    ) -> bool:
        """Let `seconds` pass and draw what is due; return whether the picture is another.

        Parameters
        ----------
        size : (int, int)
            Pixels of the window's framebuffer; with a side of 0 nothing is drawn.
        progress : callable or None
            Called every few milliseconds of a long frame. May raise while `is_outdated` can
            be true, at rest; what is on the screen then stays. A frame in motion is short,
            and would never be seen if every key interrupted it.
        """
        self._pass_time(controls, seconds)
        if min(size) < 1:
            return False
        self._notice_changes(seconds, size)
        self.can_be_given_up = self.is_resting
        progress = progress if self.is_resting or self.frame_ms > SLOW_MS else None
        self._fit_sides()
        drew = False
        state = self._state()
        self._begun = self.settings, self.view
        self.frame_ms = 0.0
        for index, side in enumerate(self._sides):
            drew |= self._update(side, index, size, progress)
        shown = (self.view, size, self.settings.exposure, len(self._sides))
        if drew or shown != self._shown:
            self._present(size)
            self._shown = shown
        is_finished = self.is_resting and all(side.is_done for side in self._sides)
        images = [side.image for side in self._sides]
        self.monitor.look(images, self.view, drew=drew, is_finished=is_finished)
        self._keep_planes(drew)
        # As it was at the beginning: in between, others may have been chosen.
        self._drawn_state = state
        return drew

    def is_outdated(self, *, is_edited: bool) -> bool:
        """Whether the frame in the making is no longer what is wanted.

        Parameters
        ----------
        is_edited : bool
            Somebody is dragging a control. What it sets has to be seen at some time, so
            a frame that it began is finished.
        """
        settings, view = self._begun
        has_other_view = _without_line(self.view) != _without_line(view)
        has_other_settings = self.settings != settings and not is_edited
        return not self.is_resting or has_other_view or has_other_settings

    def present_again(self, size: tuple[int, int]) -> None:
        """Follow the divider and the range of the difference while a frame is in the making."""
        shown = (self.view, *self._shown[1:])
        is_same = self._shown and _without_line(self.view) == _without_line(self._shown[0])
        if is_same and shown != self._shown and all(s.image.drawing for s in self._sides):
            self._present(size)
            self._shown = shown

    @property
    def inspected(self) -> Drawing | None:
        """The last complete frame of the left side, for a look at its values."""
        left = None if self.left is None else self.left.image.drawing
        return self._kept.drawing or left

    def _keep_planes(self, drew: bool) -> None:
        """Keep what is looked at under the cursor, if a long frame is to come."""
        image = self._sides[0].image
        if not (self.is_inspecting and self.is_resting and not image.is_refined):
            self._kept.release()
        elif drew and image.drawing is not None:
            self._kept.keep(image.drawing)

    def _pass_time(self, controls: Controls, seconds: float) -> None:
        self.clock.advance(seconds)
        near = None
        if any(controls.move) and self.left is not None and self.left.image.drawing is not None:
            near = clearance(self.device.gl, self.left.image.drawing)
        self.fly(controls, seconds, near)

    def _notice_changes(self, seconds: float, size: tuple[int, int]) -> None:
        # Settings are looked at as they will be: at full size, once somebody has let go.
        state = (self.view.method, self.view.aov, size)
        camera = self.camera
        moved = camera != self._last_camera or self.clock.is_running or state != self._last_state
        self._still_s = 0.0 if moved else self._still_s + seconds
        self._last_camera, self._last_state = camera, state

    def _fit_sides(self) -> None:
        wanted = 2 if self.view.compares else 1
        while len(self._sides) > wanted:
            self._sides.pop().image.release()
        while len(self._sides) < wanted:
            settings = self.settings_of_side(len(self._sides))
            side = Side(
                self.device, self.shaders, self.scene, settings, self.budget_ms, self.measured
            )
            self._sides.append(side)
        for side in self._sides:
            side.set_budget(self.budget_ms / wanted)
            side.is_governed = self.is_governed

    def settings_of_side(self, index: int) -> Settings:
        """Return the settings of the left (0) or right (1) method."""
        method = (self.view.method, self.view.other_method)[index]
        return settings_of(self.settings, method)

    def _update(
        self, side: Side, index: int, size: tuple[int, int], progress: ProgressCallback | None
    ) -> bool:
        settings = self.settings_of_side(index)
        image = image_of(self.view, settings)
        drew = side.update(
            image,
            kind_of_image(self.view, image),
            extra=self._extra(),
            camera=self.camera,
            settings=settings,
            size=size,
            seconds=self.clock.seconds,
            is_resting=self.is_resting,
            time_passes=self.times_passes,
            progress=progress,
        )
        if drew and side.image.drawing is not None:
            self.frame_ms += side.image.drawing.frame_ms
        return drew

    def _extra(self) -> tuple[str, ...]:
        if self.is_inspecting:
            return INSPECTED
        return ("beauty",) if self.shows_histogram else ()

    def _present(self, size: tuple[int, int]) -> None:
        left, right = self._sides[0], self.right
        exposure = self.settings.exposure
        self.presenter.draw(
            size,
            self.view,
            left.image,
            None if right is None else right.image,
            kinds=(left.kind, left.kind if right is None else right.kind),
            bounds=self.bounds,
            exposure=self.scene.camera.exposure if exposure is None else exposure,
            curve=str(self.settings.overrides.get("tone_map.curve", "plain")),
        )

    def release(self) -> None:
        """Free everything on the device."""
        for side in self._sides:
            side.image.release()
        self._sides.clear()
        self.presenter.release()
        self.monitor.release()
        self._kept.release()


def _without_line(view: View) -> View:
    """Return `view` with what is no matter of rendering at its default."""
    default = View()
    return dataclasses.replace(view, divider=default.divider, error_range=default.error_range)
