"""What the window shows and how it answers: everything but the window itself."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.graph.render_pass import ProgressCallback
from ssdo_gl.options.resolve import settings_for
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment import Environment, sun_of, with_sun
from ssdo_gl.scene.light_edits import with_lights
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import values
from ssdo_gl.shared_scene import SharedScene
from ssdo_gl.window.camera import Controls, jump_to
from ssdo_gl.window.canvas import DEFAULT_BUDGET_MS, Canvas, without_line
from ssdo_gl.window.first_exposure import exposed
from ssdo_gl.window.history import Edited, History
from ssdo_gl.window.live import clearance

# Frames in motion that take longer are cut into slices, too, so that the panel answers.
SLOW_MS = 50.0
# Nothing has to move for this long before full quality is worth starting: between two
# strokes of a key one does not want to wait for a frame of it.
REST_SECONDS = 0.2


class Viewer(Canvas):
    """A scene, a camera in it, and one or two methods that draw it.

    Parameters
    ----------
    device : Device
        Its context is current.
    settings : Settings
        As the command line gave them; the size is the window's business.
    source : str
        The scene as it was named.
    camera : Camera or None
        Replaces the scene's; home of the flight.
    folder : Path
        Where bookmarks, pictures and films go.
    presets : mapping of name to fields of Settings
    budget_ms, measured, read_preset
        Of `Canvas`.
    aov : str
        The image that is shown first.
    seconds : float
        Time of an animated scene at the beginning.
    shared : SharedScene or None
        What other viewers of the scene on the same device share with this one.

    Attributes
    ----------
    film_suffix : str
        Which kind of film is exported, one of `film_files.FILM_SUFFIXES`.
    can_be_given_up : bool
        Whether the frame in the making is one at rest.
    """

    _STATE = (*Canvas._STATE, "settings", "view")

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
        read_preset: Callable[[str], Mapping[str, Any]] | None = None,
        aov: str = "beauty",
        seconds: float = 0.0,
        shaders: ShaderLibrary | None = None,
        shared: SharedScene | None = None,
    ) -> None:
        super().__init__(device, settings, folder, budget_ms, presets, measured, shaders, shared)
        self.read_preset = read_preset
        self.view = dataclasses.replace(self.view, aov=aov)
        self.film_suffix = ".mp4" if find_spec("imageio_ffmpeg") else ".webp"
        self._begun = self.settings, self.view
        self.can_be_given_up = False
        self._still_s = 0.0
        self._last_camera: Camera | None = None
        self._last_state: object = None
        self._drawn_state: dict[str, Any] | None = None
        self._take(exposed(scene, settings, camera, device, self.shaders), source, camera)
        self.clock.seconds = seconds
        self.history = History(self.edited)

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
        self.history = History(self.edited)
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
        scene = with_lights(self.original, self.lights, self.lights_on)
        is_as_loaded = all(self.lights_on) and tuple(self.lights) == self.loaded.lights
        is_as_loaded &= self.original.environment is self.loaded.environment
        is_as_loaded &= len(self.original.objects) == len(self.loaded.objects)
        materials = zip(self.original.materials, self.loaded.materials, strict=False)
        is_as_loaded &= all(now is before for now, before in materials)
        self.edit(self.loaded if is_as_loaded else scene)

    def change_environment(self, environment: Environment | None) -> None:
        """Draw in another environment, and with its sun where there is a sun."""
        if sun := sun_of(environment):
            self.lights[:] = with_sun(tuple(self.lights), sun)
        self.original = dataclasses.replace(self.original, environment=environment)
        self.apply_lights()

    def edit(self, scene: Scene) -> None:
        """Draw an edited version of the same scene."""
        self.scene = scene
        for side in self._sides:
            side.show(scene, self.settings, is_new=False)
        self.touch()

    @property
    def edited(self) -> Edited:
        """All that can be edited, as it is now."""
        lights, on = tuple(self.lights), tuple(self.lights_on)
        return Edited(self.settings, lights, on, self.original, self.flight.camera())

    @property
    def is_edited(self) -> bool:
        """Whether the scene is not as its file has it."""
        return self.scene is not self.loaded

    def note_edits(self) -> None:
        """Keep a step of what was edited, unless the camera is on its way."""
        if not self.flight.is_moving and self.tour.played_s is None:
            self.history.note(self.edited)

    def go_to(self, edited: Edited) -> None:
        """Take over what was edited at another time."""
        what = self.edited.difference(edited)
        self.settings = edited.settings
        self.view = dataclasses.replace(self.view, method=edited.settings.method)
        self.lights, self.lights_on = list(edited.lights), list(edited.lights_on)
        if any(part in what for part in ("environment", "lights", "materials")):
            self.original = edited.original
            self.apply_lights()
        if "camera" in what:
            self.tour.stop()
            self.flight = jump_to(self.flight, edited.camera)

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
    def is_moving(self) -> bool:
        """Whether this frame shows something else than the last one."""
        return self._still_s == 0.0

    @property
    def is_resting(self) -> bool:
        """Whether nothing has moved for a moment."""
        return self._still_s >= REST_SECONDS

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
        sets_out = self._notice_changes(seconds, size)
        self.can_be_given_up = self.is_resting
        if sets_out and self._follow(size):
            return True
        progress = progress if self.is_resting or self.frame_ms > SLOW_MS else None
        self._fit_sides()
        drew = False
        state = self._state()
        self._begun = self.settings, self.view
        self.frame_ms = 0.0
        for index, side in enumerate(self._sides):
            drew |= self._update(side, index, size, self.is_resting, progress)
        shown = (self.view, size, self.settings.exposure, len(self._sides))
        if drew or shown != self._shown:
            self._present(self._fitting(size))
            self._shown = shown
        is_finished = self.is_resting and all(side.is_done for side in self._sides)
        images = [side.image for side in self._sides]
        self.monitor.look(images, self.view, drew=drew, is_finished=is_finished)
        self._keep_planes(drew, self.is_resting)
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
        has_other_view = without_line(self.view) != without_line(view)
        has_other_settings = self.settings != settings and not is_edited
        return not self.is_resting or has_other_view or has_other_settings

    def _pass_time(self, controls: Controls, seconds: float) -> None:
        self.clock.advance(seconds)
        near = None
        if any(controls.move) and self.left is not None and self.left.image.drawing is not None:
            near = clearance(self.device.gl, self.left.image.drawing)
        self.fly(controls, seconds, near)

    def _notice_changes(self, seconds: float, size: tuple[int, int]) -> bool:
        """Note how long nothing has moved; return whether the camera alone begins to."""
        # Settings are looked at as they will be: at full size, once somebody has let go.
        state = (self.view.method, self.view.aov, size, self.clock.seconds)
        camera = self.camera
        turns, changed = camera != self._last_camera, state != self._last_state
        moved = turns or self.clock.is_running or changed
        sets_out = self.can_be_given_up and turns and not (self.clock.is_running or changed)
        self._still_s = 0.0 if moved else self._still_s + seconds
        self._last_camera, self._last_state = camera, state
        return sets_out
