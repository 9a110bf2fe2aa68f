"""Chooses settings for the user: the most accurate in a budget.

The ladder (`presets`) says which settings are worth having. What they cost here is
measured on the user's own scene, frame and machine, a few rungs by bisection, and
remembered for scenes of the same class. `error_bound` chooses by what they lose.
"""

from __future__ import annotations

import dataclasses
import math
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from ssdo_gl.bench.analysis import percent
from ssdo_gl.bench.measure import (
    BenchRenderer,
    fingerprint,
    is_busy,
    machine_class,
    shader_fingerprint,
)
from ssdo_gl.bench.presets import Ladder, PresetRung, read_ladder
from ssdo_gl.bench.tuning.calibration import Calibrated, Calibration, opened, scene_class
from ssdo_gl.effects.methods import METHODS
from ssdo_gl.gpu.context import Device
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import SettingError

# Frames whose median is one calibrated time.
CALIBRATION_FRAMES = 7
# A calibrated time may be this part of the budget, so that the scatter of a frame's
# median does not break it.
FILL = 0.95
# A remembered time that is off by more than this factor was taken under another load.
STALE = 1.25


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


def choose_for_budget(
    scene: Scene,
    settings: Settings,
    budget_ms: float,
    *,
    camera: Camera | None = None,
    backend: str = "auto",
    device: Device | None = None,
    recalibrate: bool = False,
) -> Choice:
    """Return the most accurate measured setting that keeps a frame within `budget_ms`.

    Parameters
    ----------
    settings : Settings
        Method, size and everything that the ladder does not decide hold.
    budget_ms : float
        Milliseconds a frame, > 0.
    recalibrate : bool
        Whether to forget what was measured before.

    Raises
    ------
    CannotTuneError, ContextError
    """
    if not (budget_ms > 0.0 and math.isfinite(budget_ms)):
        raise CannotTuneError(f"--budget-ms {budget_ms:g}: must be a positive number")
    check_usable(settings)
    with opened(scene, settings, camera, backend, device) as (renderer, base):
        machine = machine_class(renderer.device)
        key = fingerprint("times", machine, scene_class(scene, base), shader_fingerprint(("",)))
        return within_budget(
            renderer, base, budget_ms, read_ladder(), Calibration(), key, recalibrate
        )


def within_budget(
    renderer: BenchRenderer,
    settings: Settings,
    budget_ms: float,
    ladder: Ladder,
    calibration: Calibration,
    key: str,
    recalibrate: bool = False,
) -> Choice:
    """Find the last rung that fits, measuring as few as possible.

    Rungs are ordered by time, so bisection finds the last one that fits. Times
    remembered for the class of scene say where to begin; the rung that is returned has
    been measured now. Where that contradicts its remembered time, all of them were taken
    under another load, and are forgotten.
    """
    start = time.perf_counter()
    known = None if recalibrate else Calibrated.read(calibration.load(key))
    measured: dict[int, float] = {}
    single = dataclasses.replace(settings, antialias=1)
    rungs, limit_ms = ladder.rungs, budget_ms * FILL

    def cost(index: int) -> float:
        if index not in measured:
            times = renderer.timed(rungs[index].applied(single), ("beauty",), CALIBRATION_FRAMES)
            measured[index] = times.frame_ms
        return measured[index]

    remembered = known.values if known else {}
    best = _last_that_fits(rungs, limit_ms, cost, remembered)
    ratios = [
        ms / remembered[rungs[i].label]
        for i, ms in measured.items()
        if rungs[i].label in remembered
    ]
    is_stale = bool(ratios) and not 1.0 / STALE <= statistics.median(ratios) <= STALE
    if is_stale:
        remembered = {}
    if best < 0:
        # Of a scene's own, the order of the rungs by time may be another one.
        for ms, i in sorted((remembered.get(r.label, math.inf), i) for i, r in enumerate(rungs)):
            if ms < min(measured.values()):
                cost(i)
        best = max((i for i, ms in measured.items() if ms <= limit_ms), default=-1)
    now = Calibrated.now(remembered | {rungs[i].label: ms for i, ms in measured.items()})
    calibration.save(key, dataclasses.asdict(now))
    index = best if best >= 0 else min(measured, key=lambda i: measured[i])
    rung, frame_ms = rungs[index], measured[index]
    tail = f"about {percent(rung.error)} error on the benched scenes; " + _how_calibrated(
        time.perf_counter() - start, known, is_stale, ratios, now
    )
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


def _how_calibrated(
    seconds: float,
    known: Calibrated | None,
    is_stale: bool,
    ratios: Sequence[float],
    now: Calibrated,
) -> str:
    """Return where times come from and how far to trust them."""
    text = f"calibrated in {seconds:.1f} s"
    if is_stale and known is not None:
        slower = statistics.median(ratios)
        text += f", anew: times of {known.when} are off by a factor of {slower:.2f}"
    elif known is not None:
        text += f", beginning with times of {known.when}"
    if is_busy(now.load):
        text += (
            f"; the machine is busy (load {now.load:.1f}), so times are too long: "
            "--recalibrate when it is not"
        )
    return text


def _last_that_fits(
    rungs: Sequence[PresetRung],
    limit_ms: float,
    cost: Callable[[int], float],
    remembered: Mapping[str, float],
) -> int:
    """Return the last rung whose cost is within `limit_ms`, -1 if none, by bisection."""
    low, high = -1, len(rungs)
    known = [i for i, rung in enumerate(rungs) if remembered.get(rung.label, math.inf) <= limit_ms]
    guess = max(known, default=None)
    while high - low > 1:
        middle = guess if guess is not None and low < guess < high else (low + high) // 2
        if cost(middle) <= limit_ms:
            low = middle
            # A guess that fits is checked from above: is the next one already too dear?
            guess = middle + 1 if guess is not None else None
        else:
            high, guess = middle, None
    return low
