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
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.window.live.governor import Governor, Rung, ladder
from ssdo_gl.window.live.live_image import LiveImage, Wish
from ssdo_gl.window.live.live_renderer import LiveRenderer
from ssdo_gl.window.views import Kind, is_averaged

# Frames at rest in which the governor may look for its rung: five for each of the four
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
        Settings that were found best for their time, for `governor.ladder`.

    Attributes
    ----------
    image : LiveImage
    governor : Governor
    is_governed : bool
        Whether the budget counts; without it, moving looks as resting does.
    """

    def __init__(
        self,
        device: Device,
        shaders: ShaderLibrary,
        scene: Scene,
        settings: Settings,
        budget_ms: float,
        measured: Sequence[Mapping[str, Any]] = (),
    ) -> None:
        renderer = LiveRenderer(scene, settings, device=device, shaders=shaders)
        self.image = LiveImage(renderer, device, shaders)
        self.is_governed = True
        self._kind = Kind.DISPLAY
        self._is_full = False
        self._full_times: deque[float] = deque(maxlen=FULL_FRAMES)
        self._measured = measured
        self._last_settings = settings
        self._rungs = ladder(settings, measured)
        self._calibration_left = CALIBRATION_FRAMES
        self.governor = Governor(budget_ms, [rung.work for rung in self._rungs])
        self._begin_coarsely(settings)

    @property
    def rung(self) -> Rung:
        """The quality in motion."""
        return self._rungs[self.governor.rung]

    @property
    def is_done(self) -> bool:
        """Whether the image is refined, and at full quality."""
        return self._is_full and self.image.is_refined

    @property
    def full_ms(self) -> float:
        """What a frame takes at full quality, milliseconds; 0 until that is known."""
        return statistics.median(self._full_times) if len(self._full_times) > 1 else 0.0

    @property
    def kind(self) -> Kind:
        """How the image becomes colours."""
        return self._kind

    def set_budget(self, budget_ms: float) -> None:
        """Hold another budget from now on."""
        if budget_ms != self.governor.budget_ms:
            self.governor.budget_ms = budget_ms

    def show(self, scene: Scene, settings: Settings, *, is_new: bool = True) -> None:
        """Draw another scene, or the same one edited."""
        self.image.renderer.show(scene, settings)
        self.image.restart()
        if is_new:
            self._restart_governor()

    def update(
        self,
        image: str,
        kind: Kind,
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
        self._fit_ladder(settings)
        self._kind = kind
        calibrates = self._calibrates(settings)
        self._calibration_left -= int(calibrates and is_resting)
        full = not self.is_governed or (is_resting and not calibrates)
        self._is_full = full
        rung = self._rungs[0 if full else self.governor.rung]
        quality = dataclasses.replace(
            rung.applied(settings),
            size=(
                max(1, round(size[0] * rung.frame_scale)),
                max(1, round(size[1] * rung.frame_scale)),
            ),
        )
        wish = Wish(image, kind, camera, quality, seconds, extra)
        drew = self.image.update(wish, time_passes=time_passes, progress=progress)
        if calibrates and is_resting and not drew:
            # All frames that this rung is good for were not enough to be sure of it.
            self._calibration_left = 0
        if drew and rung is self._rungs[0] and self.image.drawing is not None:
            self._full_times.append(self.image.drawing.frame_ms)
        # At rest the times are those of rung 0, and of more samples than in motion.
        tells = (not full or self.governor.rung == 0) and self.image.last_samples == 1
        if drew and self.is_governed and tells:
            assert self.image.drawing is not None
            self.governor.observe(self.image.drawing.frame_ms)
        return drew

    def _calibrates(self, settings: Settings) -> bool:
        """Whether the governor shall try rungs before the picture is refined.

        So that the first movement meets a rung that was measured and whose programs are
        compiled.
        """
        tries = not settings.is_reference and is_averaged(self._kind)
        return tries and not self.governor.is_settled and self._calibration_left > 0

    def _fit_ladder(self, settings: Settings) -> None:
        """Begin a new ladder where the settings call for one, on a rung as cheap."""
        if settings != self._last_settings:
            # A coarser rung may be valid where the settings are not.
            self._last_settings = settings.checked()
            self._full_times.clear()
        rungs = ladder(settings, self._measured)
        if rungs != self._rungs:
            work = self.rung.work
            self._rungs = rungs
            self._restart_governor()
            cheap = [i for i, rung in enumerate(rungs) if rung.work <= work]
            self.governor.rung = cheap[0] if cheap else len(rungs) - 1
            self._begin_coarsely(settings)

    def _begin_coarsely(self, settings: Settings) -> None:
        """Let a reference begin at its cheapest: the first step must not take seconds.

        It is not tried at rest as other methods are; it comes up from below in motion.
        """
        if settings.is_reference:
            self.governor.rung = len(self._rungs) - 1

    def _restart_governor(self) -> None:
        self.governor = Governor(self.governor.budget_ms, [rung.work for rung in self._rungs])
        self._calibration_left = CALIBRATION_FRAMES
