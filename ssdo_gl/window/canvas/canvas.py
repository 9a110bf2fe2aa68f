"""The picture of a viewer: one or two methods that draw a scene, and what is seen of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.graph.render_pass import ProgressCallback
from ssdo_gl.math3d import Vector
from ssdo_gl.options.pass_settings import overrides_from_table
from ssdo_gl.render_result import Drawing
from ssdo_gl.scene.animate import scene_at
from ssdo_gl.scene.material_edits import material_at, material_name
from ssdo_gl.settings import Settings
from ssdo_gl.shared_scene import SharedScene
from ssdo_gl.window.camera import direction_point
from ssdo_gl.window.canvas.presenter import Presenter
from ssdo_gl.window.canvas.side import Side
from ssdo_gl.window.live import INSPECTED, KeptPlanes, Monitor, surface_point
from ssdo_gl.window.scene_flight import SceneFlight
from ssdo_gl.window.views import View, image_of, is_averaged, kind_of_image, settings_of

# A frame of a 30 Hz display.
DEFAULT_BUDGET_MS = 33.0
# Of the last picture as a camera that begins to move sees it, relative to the window; and how
# long frames take where one waits for the next: a frame of a 60 Hz display.
FOLLOW_SCALE = 0.5
FOLLOW_MS = 16.0
# What of a budget is left for drawing, at least, however long it takes to show a picture.
LEAST_SHARE = 0.4


class Canvas(SceneFlight):
    """Draws a scene with the methods of a view.

    Parameters
    ----------
    presets : mapping of name to fields of Settings
    budget_ms : float or None
        What a frame may take while something moves; None: whatever it needs.
    measured : sequence of mapping
        Settings that were found best for their time, from fast to accurate.
    shared : SharedScene or None
        As of `Renderer`; None: both sides share one of their own.

    Attributes
    ----------
    settings : Settings
        The method is that of `view`.
    read_preset : callable or None
        Returns the fields of Settings in a file.
    is_inspecting, shows_histogram, times_passes : bool
        What besides the picture has to be made for somebody who looks at it.
    monitor : Monitor
        Alarms, and the error of the left side against the right one.
    is_drawing : bool
        Whether a frame is in the making, which may have freed what the last one drew.
    frame_ms : float
        Of the last frame, both sides together.
    stretches : bool
        Whether who shows the picture stretches it to the size of the window.
    showing_ms : float
        What it takes to bring a picture and the panel onto the screen.
    """

    def __init__(
        self,
        device: Device,
        settings: Settings,
        folder: Path,
        budget_ms: float | None,
        presets: Mapping[str, Mapping[str, Any]],
        measured: Sequence[Mapping[str, Any]],
        shaders: ShaderLibrary | None,
        shared: SharedScene | None,
    ) -> None:
        super().__init__(folder)
        self.settings = settings
        self.view = View(method=settings.method)
        self.presets = presets
        self.read_preset: Callable[[str], Mapping[str, Any]] | None = None
        self.device = device
        self.shaders = shaders or ShaderLibrary(device.gl, computes=device.computes)
        self.presenter = Presenter(device, self.shaders)
        self.measured = measured
        self.budget_ms = budget_ms or DEFAULT_BUDGET_MS
        self.is_governed = budget_ms is not None
        self.is_inspecting = False
        self.shows_histogram = False
        self.times_passes = False
        self.stretches = False
        self.frame_ms = self.showing_ms = 0.0
        self.monitor = Monitor(device, self.shaders)
        self._kept = KeptPlanes(device)
        self.is_drawing = False
        self._owns_shared = shared is None
        self._shared = shared
        self._sides: list[Side] = []
        self._shown: tuple[Any, ...] = ()

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
        return self._shown[1] if self._shown else self.settings.size

    @property
    def has_drawing(self) -> bool:
        """Whether there is a frame whose depth and images can be read."""
        return self.left is not None and self.left.image.drawing is not None

    def choose_preset(self, name: str) -> None:
        """Take over what a preset sets; the method stays, unless the preset is one.

        Raises
        ------
        SettingError
            If a value is out of range; the settings then stay as they are.
        """
        self.settings = self._with_preset(self.presets[name])
        self.view = dataclasses.replace(self.view, method=self.settings.method)

    def add_preset(self, name: str, fields: Mapping[str, Any]) -> None:
        """Offer a preset and take it over; raises SettingError as `choose_preset` does."""
        self._with_preset(fields)
        self.presets = {**self.presets, name: fields}
        self.choose_preset(name)

    def _with_preset(self, fields: Mapping[str, Any]) -> Settings:
        method = fields.get("method", self.view.method)
        overrides_from_table(fields.get("overrides", {}))
        return settings_of(dataclasses.replace(self.settings, **fields), method).checked()

    def choose_method(self, method: str) -> None:
        """Show another method; an estimator that it does not know is dropped."""
        self.view = dataclasses.replace(self.view, method=method)
        self.settings = settings_of(self.settings, method)

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

    def choose_material(self, uv: tuple[float, float]) -> str | None:
        """Edit what the surface under a place of the picture is made of; return its name."""
        point = self.pick(uv)
        if point is None:
            return None
        found = material_at(scene_at(self.original, self.clock.seconds), point)
        if found is None or found >= len(self.loaded.materials):
            return None
        self.material = found
        return material_name(self.loaded, found)

    def present_again(self, size: tuple[int, int]) -> None:
        """Follow the divider and the range of the difference while a frame is in the making."""
        shown = (self.view, *self._shown[1:])
        is_same = self._shown and without_line(self.view) == without_line(self._shown[0])
        if is_same and shown != self._shown and all(s.image.drawing for s in self._sides):
            self._present(self._fitting(size))
            self._shown = shown

    @property
    def inspected(self) -> Drawing | None:
        """The last complete frame of the left side, for a look at its values.

        None while the next one is in the making, which may have freed it, if none was kept.
        """
        if self._kept.drawing is not None or self.left is None or self.is_drawing:
            return self._kept.drawing
        return self.left.image.drawing

    def _keep_planes(self, drew: bool, is_resting: bool) -> None:
        """Keep what is looked at under the cursor, if a long frame is to come."""
        image = self._sides[0].image
        if not (self.is_inspecting and is_resting and not image.is_refined):
            self._kept.release()
        elif drew and image.drawing is not None:
            self._kept.keep(image.drawing)

    def _fit_sides(self) -> None:
        wanted = 2 if self.view.compares else 1
        while len(self._sides) > wanted:
            self._sides.pop().image.release()
        while len(self._sides) < wanted:
            self._sides.append(self._new_side(self.settings_of_side(len(self._sides))))
        for side in self._sides:
            left_ms = max(self.budget_ms - self.showing_ms, LEAST_SHARE * self.budget_ms)
            side.governor.budget_ms = left_ms / wanted
            side.is_governed = self.is_governed

    def _new_side(self, settings: Settings) -> Side:
        self._shared = self._shared or SharedScene(self.device.gl, self.scene)
        return Side(
            self.device,
            self.shaders,
            self.scene,
            settings,
            self.budget_ms,
            self.measured,
            self._shared,
        )

    def settings_of_side(self, index: int) -> Settings:
        """Return the settings of the left (0) or right (1) method."""
        method = (self.view.method, self.view.other_method)[index]
        return settings_of(self.settings, method)

    def _update(
        self,
        side: Side,
        index: int,
        size: tuple[int, int],
        is_resting: bool,
        progress: ProgressCallback | None,
    ) -> bool:
        settings = self.settings_of_side(index)
        image = image_of(self.view, settings)
        self.is_drawing = True
        try:
            drew = side.update(
                image,
                kind_of_image(self.view, image),
                extra=self._extra(),
                camera=self.camera,
                settings=settings,
                size=size,
                seconds=self.clock.seconds,
                is_resting=is_resting,
                time_passes=self.times_passes,
                progress=progress,
            )
        finally:
            self.is_drawing = False
        if drew and side.image.drawing is not None:
            self.frame_ms += side.image.drawing.frame_ms
        return drew

    def _extra(self) -> tuple[str, ...]:
        if self.is_inspecting:
            return INSPECTED
        return ("beauty",) if self.shows_histogram else ()

    def pixels(self) -> NDArray[np.uint8]:
        """Return the picture as `Presenter.pixels` does, as large as it is shown."""
        picture = self.presenter.picture
        if picture is not None and picture.size != self.picture_size:
            self._present(self.picture_size)
        return self.presenter.pixels()

    def show_picture(self, pixels: NDArray[np.uint8]) -> None:
        """Show a picture made elsewhere, (height, width, 3), until another one is due."""
        self.presenter.show(pixels)
        # Of no side at all, so that the next frame of the viewer is shown again.
        self._shown = (*self._shown[:3], 0)

    def _fitting(self, size: tuple[int, int]) -> tuple[int, int]:
        """Return at which size to turn numbers into colours, of `size` or less.

        A picture drawn for motion is stretched as colours, by a third of the work.
        """
        left = self._sides[0]
        is_whole = self.view.compares or not self.stretches or not is_averaged(left.kind)
        if is_whole or left.image.drawing is None:
            return size
        width, height = left.image.drawing.view.size
        return min(width, size[0]), min(height, size[1])

    def _follow(self, size: tuple[int, int]) -> bool:
        """Answer a camera that begins to move by the last picture, where frames take longer.

        Whoever looks around waits for the first picture, and sees it for one frame.
        """
        drawings = [side.image.drawing for side in self._sides]
        took_ms = sum(drawing.frame_ms for drawing in drawings if drawing is not None)
        # There is none after one that was given up, which was a long one.
        if all(drawings) and took_ms < min(FOLLOW_MS, self.budget_ms):
            return False
        width, height = (max(1, round(FOLLOW_SCALE * n)) for n in size)
        return self.presenter.follow(self.camera, (width, height))

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
        # Two methods see the same surfaces, so that the depth of one is that of both.
        self.presenter.remember(left.image.drawing if self.stretches else None, self.camera)

    def release(self) -> None:
        """Free everything on the device."""
        for side in self._sides:
            side.image.release()
        self._sides.clear()
        if self._owns_shared and self._shared is not None:
            self._shared.geometry.release()
            self._shared = None
        self.presenter.release()
        self.monitor.release()
        self._kept.release()


def without_line(view: View) -> View:
    """Return `view` with what is no matter of rendering at its default."""
    default = View()
    return dataclasses.replace(view, divider=default.divider, error_range=default.error_range)
