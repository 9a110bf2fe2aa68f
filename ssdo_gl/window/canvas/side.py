"""One side of the window: a method, its image, and the governor that keeps it fluid."""

from __future__ import annotations

import dataclasses
import statistics
from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any

from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.graph.render_pass import ProgressCallback
from ssdo_gl.images.display import ColorMapping
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.shared_scene import SharedScene
from ssdo_gl.window.live import FrameRequest, Governor, LiveImage, QualityLevel, quality_levels
from ssdo_gl.window.views import is_averaged

# Frames at rest in which the governor may look for its level: five for each of the four
# or five it will try on a slow machine.
CALIBRATION_FRAMES = 24
# Frames at full quality whose median tells what one takes.
FULL_FRAMES = 9


class Side:
    """Draws one method: as well as the budget allows while moving, as asked for at rest.

    Parameters
    ----------
    budget_ms : float
        What a frame may take while something moves.
    measured : sequence of mapping
        Settings that were found best for their time, for `governor.quality_levels`.
    shared : SharedScene or None
        As of `Renderer`.

    Attributes
    ----------
    is_governed : bool
        Whether the budget counts; without it, moving looks as resting does.
    kind : ColorMapping
        How the image becomes colours.
    """

    def __init__(
        self,
        device: Device,
        shaders: ShaderLibrary,
        scene: Scene,
        settings: Settings,
        budget_ms: float,
        measured: Sequence[Mapping[str, Any]] = (),
        shared: SharedScene | None = None,
    ) -> None:
        renderer = Renderer(scene, settings, device=device, shaders=shaders, shared=shared)
        self.image = LiveImage(renderer, device, shaders)
        self.is_governed = True
        self.kind = ColorMapping.DISPLAY
        self._is_full = False
        self._full_times: deque[float] = deque(maxlen=FULL_FRAMES)
        self._measured = measured
        self._last_settings = settings
        self._levels = quality_levels(settings, measured)
        self._calibration_left = CALIBRATION_FRAMES
        self.governor = Governor(budget_ms, [level.work for level in self._levels])
        self.governor.climb()
        self._governed = ""
        # Of images that are not shown now: their governors, and what they may yet try at rest.
        self._others: dict[str, tuple[Governor, int]] = {}

    @property
    def level(self) -> QualityLevel:
        """The quality in motion."""
        return self._levels[self.governor.level]

    @property
    def is_done(self) -> bool:
        """Whether the image is refined, and at full quality."""
        return self._is_full and self.image.is_refined

    @property
    def full_ms(self) -> float:
        """What a frame takes at full quality, milliseconds; 0 until that is known."""
        return statistics.median(self._full_times) if len(self._full_times) > 1 else 0.0

    def show(self, scene: Scene, settings: Settings, *, is_new: bool = True) -> None:
        """Draw another scene, or the same one edited."""
        self.image.renderer.use_scene(scene)
        self.image.renderer.use(settings)
        self.image.restart()
        if is_new:
            self._restart_governor()
            self.governor.climb()

    def update(
        self,
        image: str,
        kind: ColorMapping,
        *,
        extra: tuple[str, ...],
        camera: Camera,
        settings: Settings,
        size: tuple[int, int],
        seconds: float,
        is_resting: bool,
        time_passes: bool,
        progress: ProgressCallback | None,
    ) -> bool:
        """Draw one frame if there is anything left to draw; return whether there was.

        Parameters
        ----------
        image : str
            AOV name or ``display``.
        extra : tuple of str
            Images that the inspector reads besides.
        settings : Settings
            As the user wants them; the size is `size`.
        size : (int, int)
            Pixels of the window's framebuffer.
        is_resting : bool
            Nothing has moved for a moment: draw at full quality and refine.
        """
        self._fit_levels(settings)
        self._govern(image)
        self.kind = kind
        calibrates = self._calibrates(settings)
        self._calibration_left -= int(calibrates and is_resting)
        full = not self.is_governed or (is_resting and not calibrates)
        self._is_full = full
        level = self._levels[0 if full else self.governor.level]
        scale = level.frame_scale
        pixels = max(1, round(size[0] * scale)), max(1, round(size[1] * scale))
        quality = dataclasses.replace(level.applied(settings), size=pixels)
        request = FrameRequest(image, kind, camera, quality, seconds, extra)
        drew = self.image.update(request, time_passes=time_passes, progress=progress)
        if calibrates and is_resting and not drew:
            # All frames that this level is good for were not enough to be sure of it.
            self._calibration_left = 0
        if drew and level is self._levels[0] and self.image.drawing is not None:
            self._full_times.append(self.image.drawing.frame_ms)
        # At rest the times are those of level 0, and of more samples than in motion.
        tells = (not full or self.governor.level == 0) and self.image.last_samples == 1
        if drew and self.is_governed and tells:
            assert self.image.drawing is not None
            self.governor.observe(self.image.drawing.frame_ms)
        return drew

    def _calibrates(self, settings: Settings) -> bool:
        """Whether the governor shall try levels before the picture is refined.

        So that the first movement meets a level that was measured and whose programs are
        compiled. What is shown at full quality stays, however long a frame of it took.
        """
        tries = not (settings.is_reference or self._is_full) and is_averaged(self.kind)
        return tries and not self.governor.is_settled and self._calibration_left > 0

    def _fit_levels(self, settings: Settings) -> None:
        """Begin new levels where the settings call for one, on a level as cheap.

        They are tried at rest for another method alone: who drags a control looks at the
        picture, which is not to change for the governor's sake.
        """
        is_same = settings.method == self._last_settings.method
        if settings != self._last_settings:
            # A coarser level may be valid where the settings are not.
            self._last_settings = settings.checked()
            self._full_times.clear()
        levels = quality_levels(settings, self._measured)
        if levels != self._levels:
            work = self.level.work
            self._levels = levels
            self._restart_governor()
            self._calibration_left = 0 if is_same else CALIBRATION_FRAMES
            cheap = [i for i, level in enumerate(levels) if level.work <= work]
            self.governor.level = cheap[0] if cheap else len(levels) - 1
            if not is_same:
                self.governor.climb()

    def _govern(self, image: str) -> None:
        """Go on with what is known of the times of `image`.

        Those of depth say nothing of beauty, which would come back at a level that was never
        compiled: seconds, in the middle of a motion. An image that is new begins with the
        coarsest level that another one has needed.
        """
        if image == self._governed:
            return
        present = self.governor, self._calibration_left
        if self._governed:
            self._others[self._governed] = present
            new = Governor(self.governor.budget_ms, [level.work for level in self._levels])
            new.level = max(governor.level for governor, _ in self._others.values())
            present = new, 0
        budget_ms = self.governor.budget_ms
        self.governor, self._calibration_left = self._others.pop(image, present)
        self.governor.budget_ms = budget_ms
        self._governed = image

    def _restart_governor(self) -> None:
        self._others.clear()
        self.governor = Governor(self.governor.budget_ms, [level.work for level in self._levels])
        self._calibration_left = CALIBRATION_FRAMES
