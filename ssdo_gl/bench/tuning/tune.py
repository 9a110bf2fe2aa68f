"""Chooses settings for the user: the most accurate in a budget.

The ladder (`presets`) says which settings are worth having. What they cost here is
measured on the user's own scene, frame and machine: a rung in the middle, whose time says
where to look, and those about the end of the budget. `error_bound` chooses by what they lose.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from ssdo_gl.bench.analysis import percent
from ssdo_gl.bench.measure import BenchRenderer, is_busy, load_average
from ssdo_gl.bench.presets import Ladder, PresetRung, read_ladder
from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import SettingError
from ssdo_gl.settings.methods import METHODS

# Frames whose median is one calibrated time.
CALIBRATION_FRAMES = 7
# A calibrated time may be this part of the budget, so that the scatter of a frame's
# median does not break it.
FILL = 0.95


class CannotTuneError(SettingError):
    """A budget or an error bound that makes no sense for the chosen method."""


@dataclass(frozen=True)
class Choice:
    """What was chosen and why.

    Attributes
    ----------
    sentence : str
        The reason in one line.
    holds : bool
        Whether the request can be met; if not, `settings` comes nearest.
    frame_ms : float
        Expected frame time; NaN if it was not calibrated.
    error : float
        Expected error (RMSE / mean of the reference): of this scene if it was calibrated,
        else of the benched scenes.
    """

    settings: Settings
    sentence: str
    holds: bool
    frame_ms: float = math.nan
    error: float = math.nan


def check_usable(settings: Settings) -> None:
    """Raise unless the ladder's settings make a difference to the method."""
    if not METHODS[settings.method].estimators:
        valid = ", ".join(name for name, method in METHODS.items() if method.estimators)
        raise CannotTuneError(
            f"--method {settings.method}: --budget-ms and --max-error choose settings of {valid}"
        )


@contextmanager
def opened(
    scene: Scene, settings: Settings, camera: Camera | None, backend: str, device: Device | None
) -> Iterator[tuple[BenchRenderer, Settings]]:
    """Yield a renderer for one calibration and its settings; close what was opened for it."""
    used = device or create_context(backend)
    if camera is not None:
        scene = dataclasses.replace(scene, camera=camera)
    # What is asked of the choice is not what the references should stop at.
    unbounded = dataclasses.replace(settings, max_error=None)
    try:
        with Renderer(scene, unbounded, device=used) as renderer:
            yield BenchRenderer(renderer), renderer.settings
    finally:
        if device is None:
            used.release()


def choose_for_budget(
    scene: Scene,
    settings: Settings,
    budget_ms: float,
    *,
    camera: Camera | None = None,
    backend: str = "auto",
    device: Device | None = None,
) -> Choice:
    """Return the most accurate measured setting that keeps a frame within `budget_ms`.

    Parameters
    ----------
    settings : Settings
        Method, size and everything that the ladder does not decide hold.
    budget_ms : float
        Milliseconds a frame, > 0.

    Raises
    ------
    CannotTuneError, ContextError
    """
    if not (budget_ms > 0.0 and math.isfinite(budget_ms)):
        raise CannotTuneError(f"--budget-ms {budget_ms:g}: must be a positive number")
    check_usable(settings)
    with opened(scene, settings, camera, backend, device) as (renderer, base):
        return within_budget(renderer, base, budget_ms, read_ladder())


def within_budget(
    renderer: BenchRenderer, settings: Settings, budget_ms: float, ladder: Ladder
) -> Choice:
    """Find the last rung that fits, measuring as few as possible."""
    start = time.perf_counter()
    measured: dict[int, float] = {}
    single = dataclasses.replace(settings, antialias=1)
    rungs = ladder.rungs

    def cost(index: int) -> float:
        times = renderer.timed(rungs[index].applied(single), ("beauty",), CALIBRATION_FRAMES)
        measured[index] = times.frame_ms
        return times.frame_ms

    best = _last_that_fits(rungs, budget_ms * FILL, cost)
    index = best if best >= 0 else min(measured, key=lambda i: measured[i])
    rung, frame_ms = rungs[index], measured[index]
    tail = (
        f"about {percent(rung.error)} error on the benched scenes; "
        f"calibrated in {time.perf_counter() - start:.1f} s"
    )
    load = load_average()
    if load is not None and is_busy(load):
        tail += f"; the machine is busy (load {load:.1f}), so times are too long"
    if best < 0:
        sentence = (
            f"no measured setting fits {budget_ms:g} ms, with {percent(1.0 - FILL)} to spare, at"
            f" {settings.size[0]}x{settings.size[1]}: the cheapest, {rung.label}, takes"
            f" {frame_ms:.1f} ms ({tail})"
        )
    else:
        sentence = f"chose {rung.label}: {frame_ms:.1f} ms of {budget_ms:g} ms, {tail}"
        if index + 1 in measured:
            following = rungs[index + 1]
            sentence += f"; {following.label} would take {measured[index + 1]:.1f} ms"
    return Choice(rung.applied(settings), sentence, best >= 0, frame_ms, rung.error)


def _last_that_fits(
    rungs: Sequence[PresetRung], limit_ms: float, cost: Callable[[int], float]
) -> int:
    """Return the last rung whose cost is within `limit_ms`, -1 if none.

    Rungs are ordered by time. If a scene's times grow as those of the ladder do, one of them
    tells where the last one that fits is.
    """
    low, high = -1, len(rungs)
    middle = high // 2
    while high - low > 1:
        ms = cost(middle)
        if ms <= limit_ms:
            low = middle
        else:
            high = middle
        allowed = limit_ms / ms * rungs[middle].relative_time
        guess = sum(rung.relative_time <= allowed for rung in rungs) - 1
        middle = min(max(guess, low + 1), high - 1)
    return low
