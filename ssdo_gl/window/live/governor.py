"""Holds a frame-time budget by choosing one of ever cheaper levels of quality. Pure.

The levels go from the user's own settings down. The governor only ever looks at the
times of past frames; it learns what each level costs as it uses it.
"""

from __future__ import annotations

import dataclasses
import math
import statistics
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ssdo_gl.settings import Settings

# Fewer depth reads than this leave a pattern that no filter hides.
FEWEST_SAMPLES = 8
# Sizes of the picture relative to the window, once samples alone do not suffice.
FRAME_SCALES = (0.85, 0.7, 0.6, 0.5, 0.42, 0.35, 0.3, 0.25, 0.2, 0.16)

# A decision to go down needs this many frames over budget, so that one hiccup of the
# system does not count; the median of three ignores one of them.
FRAMES_TO_LOWER = 3
# Going up can wait: one looks at motion now, and it must be sure to hold.
FRAMES_TO_RAISE = 20
# Frames this many times over budget are no hiccup once there are two in a row: one waits
# for them, so nothing more is waited for.
STALL = 8.0
# The level above must be expected to use no more than this part of the budget. What
# lies between here and 1 is the hysteresis.
RAISE_FILL = 0.85
# No level is taken to cost more than this over the one below it: halving the resolution
# quarters the work at best, and what was seen beyond is a hiccup.
LARGEST_STEP = 4.0
# Frames that are not measured after a change of level: programs compile and textures
# are made in the first.
SETTLING_FRAMES = 2


@dataclass(frozen=True)
class QualityLevel:
    """One quality of what is drawn in motion.

    Attributes
    ----------
    samples : int
        Depth reads per pixel.
    steps : int
        Of them along each direction.
    resolution_scale : float
        Of the estimators.
    frame_scale : float
        Of the whole picture relative to the window; it is stretched to fill it.
    """

    samples: int
    steps: int
    resolution_scale: float
    frame_scale: float = 1.0

    @property
    def work(self) -> float:
        """What it costs, roughly: depth reads per pixel of the window."""
        return self.samples * (self.resolution_scale * self.frame_scale) ** 2

    def applied(self, settings: Settings) -> Settings:
        """Return `settings` at this quality; the size is left to the caller."""
        return dataclasses.replace(
            settings,
            samples=self.samples,
            steps=self.steps,
            resolution_scale=self.resolution_scale,
        )


def quality_levels(
    settings: Settings, measured: Sequence[Mapping[str, Any]] = ()
) -> tuple[QualityLevel, ...]:
    """Return the levels under `settings`, each cheaper than the one before.

    Samples go first, because the filter and refinement at rest hide their loss best;
    then the estimators' resolution; the picture's own resolution last. Soft shadows stay as
    they are: with fewer reads they come out as dots, for a fifth of the time.

    Parameters
    ----------
    measured : sequence of mapping
        ``samples``, ``steps`` and ``resolution_scale`` of settings that were found best
        for their time, from fast to accurate; those under `settings` become levels.
    """
    levels = [QualityLevel(settings.samples, settings.steps, settings.resolution_scale)]

    def add(samples: int, steps: int, scale: float) -> None:
        level = QualityLevel(samples, min(steps, samples), scale)
        if level.work < levels[-1].work and samples >= FEWEST_SAMPLES:
            levels.append(level)

    if not settings.is_reference:
        halves = [(settings.samples >> i, settings.steps, 1.0 / (1 + (i > 1))) for i in range(4)]
        known = [(f["samples"], f["steps"], f["resolution_scale"]) for f in reversed(measured)]
        for samples, steps, scale in known or halves:
            add(samples, steps, min(scale, settings.resolution_scale))
        while levels[-1].samples >= 2 * FEWEST_SAMPLES:
            add(levels[-1].samples // 2, levels[-1].steps, levels[-1].resolution_scale)
    last = levels[-1]
    levels += [dataclasses.replace(last, frame_scale=factor) for factor in FRAME_SCALES]
    return tuple(levels)


class Governor:
    """Chooses the level for the next frame from the times of the last ones.

    Parameters
    ----------
    budget_ms : float
        What a frame may take, > 0.
    works : sequence of float
        What the levels are expected to cost relative to one another, falling; level 0 is
        the best. Times will fall more slowly: part of a frame is the same in all.

    Attributes
    ----------
    level : int
        For the next frame.
    """

    def __init__(self, budget_ms: float, works: Sequence[float]) -> None:
        self.budget_ms = budget_ms
        self.level = 0
        self._works = tuple(works)
        self._times: deque[float] = deque(maxlen=FRAMES_TO_RAISE)
        self._settling = SETTLING_FRAMES
        self._last: tuple[int, float] | None = None
        # How much dearer a level is than the one below it, as far as that was seen.
        self._ratio: dict[int, float] = {}
        self._usual_ms: float | None = None
        self._climbs = False

    def climb(self) -> None:
        """Begin at the cheapest level, and go up as soon as there is room for more.

        Nothing is known of the device yet, and the first frame of a motion shall not take
        seconds.
        """
        self.level = len(self._works) - 1
        self._climbs = True

    @property
    def is_settled(self) -> bool:
        """Whether the present level was measured and is to be kept for now."""
        if self._usual_ms is None or self._climbs:
            return False
        return self._usual_ms <= self.budget_ms or self.is_exhausted

    @property
    def is_exhausted(self) -> bool:
        """Whether even the cheapest level does not keep the budget."""
        at_the_end = self.level == len(self._works) - 1
        return at_the_end and self._usual_ms is not None and self._usual_ms > self.budget_ms

    def observe(self, frame_ms: float) -> int:
        """Take the time of a frame drawn at `level`; return the level for the next."""
        if self._settling > 0:
            self._settling -= 1
            if self._settling > 0 or frame_ms <= STALL * self.budget_ms:
                return self.level
        self._times.append(frame_ms)
        stalls = len(self._times) > 1 and min(list(self._times)[-2:]) > STALL * self.budget_ms
        if len(self._times) < FRAMES_TO_LOWER and not stalls:
            return self.level
        recent = statistics.median(list(self._times)[-FRAMES_TO_LOWER:])
        self._usual_ms = statistics.median(self._times)
        if recent > self.budget_ms:
            self._climbs = False
            self._learn(recent)
            self._lower(recent)
        elif self._climbs:
            self._learn(recent)
            self._climbs = self._raise_far(recent)
        elif len(self._times) == FRAMES_TO_RAISE:
            self._learn(self._usual_ms)
            if self.level > 0:
                expected = self._expected(self.level - 1, self._usual_ms)
                if expected <= RAISE_FILL * self.budget_ms:
                    self._move(self.level - 1, self._usual_ms)
        return self.level

    def _lower(self, recent_ms: float) -> None:
        """Go down to the first level that is expected to do."""
        for level in range(self.level + 1, len(self._works)):
            is_last = level == len(self._works) - 1
            if is_last or self._expected(level, recent_ms) <= self.budget_ms:
                self._move(level, recent_ms)
                return

    def _raise_far(self, recent_ms: float) -> bool:
        """Go up to the best level that is expected to do; False if there is none."""
        for level in range(self.level):
            if self._expected(level, recent_ms) <= RAISE_FILL * self.budget_ms:
                self._move(level, recent_ms)
                return True
        return False

    def _expected(self, level: int, here_ms: float) -> float:
        """Return what `level` should take, given what the present one takes."""
        low, high = min(level, self.level), max(level, self.level)
        factor = math.prod(
            self._ratio.get(r, self._works[r] / self._works[r + 1]) for r in range(low, high)
        )
        return here_ms / factor if level > self.level else here_ms * factor

    def _learn(self, here_ms: float) -> None:
        """Note what the levels between the last one and this one have cost or saved."""
        if self._last is None or self._last[0] == self.level or here_ms <= 0.0:
            return
        level, then_ms = self._last
        steps = level - self.level
        ratio = (here_ms / then_ms) ** (1.0 / steps)
        for between in range(min(level, self.level), max(level, self.level)):
            self._ratio[between] = min(max(1.0, ratio), LARGEST_STEP)
        self._last = None

    def _move(self, level: int, here_ms: float) -> None:
        self._last = (self.level, here_ms) if here_ms > 0.0 else None
        self.level = level
        self._usual_ms = None
        self._times.clear()
        self._settling = SETTLING_FRAMES
