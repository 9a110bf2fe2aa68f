"""Chooses settings for the user: the most accurate in a budget, the cheapest in an error.

The ladder (`presets`) says which settings are worth having. What they cost here is
measured on the user's own scene, frame and machine, a few rungs by bisection, and
remembered for scenes of the same class; what they lose is measured against a short
ray-traced reference of the scene.
"""

from __future__ import annotations

import dataclasses
import math
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from ssdo_gl.bench.analysis import percent
from ssdo_gl.bench.bench_renderer import BenchRenderer
from ssdo_gl.bench.bootstrap import draw, rmse_interval
from ssdo_gl.bench.calibration import Calibrated, Calibration, opened, scene_class
from ssdo_gl.bench.clock import is_busy
from ssdo_gl.bench.errors import judge, judged_pixels
from ssdo_gl.bench.fingerprint import fingerprint, scene_fingerprint, shader_fingerprint
from ssdo_gl.bench.machine import machine_class
from ssdo_gl.bench.panels import panel_named
from ssdo_gl.bench.presets import Ladder, PresetRung, read_ladder
from ssdo_gl.bench.reference_cache import Goal, ReferenceCache, obtain
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
# Errors are calibrated on a smaller frame: a reference of the whole one would take minutes.
# A larger frame shows more detail, so errors there are smaller, not larger.
CALIBRATION_PIXELS = 320 * 180
CALIBRATION_SPP = 16
CALIBRATION_SEEDS = 2
# The reference's standard error for the calibration, relative to the mean; it is subtracted,
# so what is left of it is far smaller.
CALIBRATION_GOAL = 0.03
CALIBRATION_SECONDS = 20.0


class CannotTuneError(SettingError):
    """A budget or an error bound that makes no sense for the chosen method."""


@dataclass(frozen=True)
class Choice:
    """What was chosen and why.

    Attributes
    ----------
    settings : Settings
    sentence : str
        The reason in one line.
    holds : bool
        Whether the request can be met; if not, `settings` comes nearest.
    frame_ms : float
        Expected frame time; NaN if it was not calibrated.
    error : float
        Expected error (RMSE / mean of the near-field reference): of this scene if it was
        calibrated, else of the benched scenes.
    """

    settings: Settings
    sentence: str
    holds: bool
    frame_ms: float = math.nan
    error: float = math.nan


def _usable(settings: Settings) -> None:
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
    _usable(settings)
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
            f"no measured setting fits {budget_ms:g} ms at {settings.size[0]}x"
            f"{settings.size[1]}: the cheapest, {rung.label}, takes {frame_ms:.1f} ms ({tail})"
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


def choose_for_error(
    scene: Scene,
    settings: Settings,
    max_error: float,
    *,
    camera: Camera | None = None,
    backend: str = "auto",
    device: Device | None = None,
    allow_rays: bool = True,
    recalibrate: bool = False,
) -> Choice:
    """Return the cheapest measured setting whose error is at most `max_error`.

    The error is RMSE over the mean of the near-field reference, measured on this scene.

    Parameters
    ----------
    max_error : float
        Relative, > 0: 0.05 is five percent of the mean.
    allow_rays : bool
        Whether the ray-traced near field may be chosen where no screen-space setting is
        accurate enough; for a window it may not.
    recalibrate : bool
        Whether to forget what was measured before.

    Raises
    ------
    CannotTuneError, ContextError
    """
    if not (max_error > 0.0 and math.isfinite(max_error)):
        raise CannotTuneError(f"--max-error {max_error:g}: must be a positive number")
    _usable(settings)
    ladder = read_ladder()
    with opened(scene, settings, camera, backend, device) as (renderer, base):
        calibration = Calibration()
        key = fingerprint(
            "errors",
            machine_class(renderer.device),
            scene_fingerprint(renderer.scene),
            dataclasses.replace(base, seed=0),
            shader_fingerprint(("",)),
        )
        known = None if recalibrate else Calibrated.read(calibration.load(key))
        start = time.perf_counter()
        if known is None or set(known.values) != {rung.label for rung in ladder.rungs}:
            known = Calibrated.now(measured_errors(renderer, base, ladder.rungs, ReferenceCache()))
            calibration.save(key, dataclasses.asdict(known))
            how = f"calibrated in {time.perf_counter() - start:.1f} s"
        else:
            how = f"calibrated {known.date}; --recalibrate measures again"
    return within_error(base, max_error, ladder.rungs, known.values, how, allow_rays)


def measured_errors(
    renderer: BenchRenderer,
    settings: Settings,
    rungs: Sequence[PresetRung],
    cache: ReferenceCache,
) -> dict[str, float]:
    """Return the upper end of each rung's error interval on this scene, by label.

    The interval is over pixel blocks, so its end allows for views whose content is like
    that of the calibrated one.
    """
    panel = panel_named("near")
    small = dataclasses.replace(
        settings, size=_smaller(settings.size), antialias=1, max_error=None, method="bounce",
        estimator=None,
    )  # fmt: skip
    mask = judged_pixels(renderer, small)
    if not mask.any():
        raise CannotTuneError("--max-error: the camera sees no surface, so there is no error")
    reference = obtain(
        renderer,
        dataclasses.replace(small, method=panel.method, spp=CALIBRATION_SPP),
        (panel.aov,),
        Goal(panel.aov, CALIBRATION_GOAL, True, CALIBRATION_SECONDS),
        mask,
        cache,
    )
    alone = dataclasses.replace(panel, parts=())
    found = {}
    for rung in rungs:
        renderings = [
            renderer.images(
                rung.applied(
                    dataclasses.replace(small, method=settings.method, seed=small.seed + seed)
                ),
                (panel.aov,),
            )
            for seed in range(CALIBRATION_SEEDS)
        ]
        blocks = judge(alone, renderings, reference, mask, 0.0).blocks
        draws = draw(blocks.block_count, blocks.seed_count)
        found[rung.label] = rmse_interval(blocks, draws, relative=True).high
    return found


def _smaller(size: tuple[int, int]) -> tuple[int, int]:
    """Return a size of the same shape with at most `CALIBRATION_PIXELS` pixels."""
    width, height = size
    factor = min(1.0, math.sqrt(CALIBRATION_PIXELS / (width * height)))
    return max(1, round(width * factor)), max(1, round(height * factor))


def within_error(
    settings: Settings,
    max_error: float,
    rungs: Sequence[PresetRung],
    errors: Mapping[str, float],
    how: str,
    allow_rays: bool,
) -> Choice:
    """Return the first rung, from the cheapest, whose error is surely small enough.

    `how` says where the errors come from.
    """
    for rung in rungs:
        expected = errors[rung.label]
        if expected <= max_error:
            sentence = (
                f"chose {rung.label}: error at most {percent(expected)} of the mean, "
                f"{percent(max_error)} allowed ({how})"
            )
            return Choice(rung.applied(settings), sentence, True, error=expected)
    best = min(rungs, key=lambda rung: errors[rung.label])
    reached = percent(errors[best.label])
    if allow_rays:
        traced = dataclasses.replace(
            settings, method="reference-near", estimator=None, max_error=max_error
        ).checked()
        sentence = (
            f"chose rays (reference-near): no screen-space setting is within "
            f"{percent(max_error)}; the best, {best.label}, reaches {reached} ({how})"
        )
        return Choice(traced, sentence, True, error=max_error)
    sentence = (
        f"no measured setting is within {percent(max_error)}: the most accurate, {best.label}, "
        f"reaches {reached} ({how})"
    )
    return Choice(best.applied(settings), sentence, False, error=errors[best.label])
