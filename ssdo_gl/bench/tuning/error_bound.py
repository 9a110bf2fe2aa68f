"""Chooses settings for the user: the cheapest whose error stays below a bound.

What the rungs of the ladder (`presets`) lose is measured on the user's own scene, against a
short ray-traced reference, and remembered.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ssdo_gl.bench.analysis import percent
from ssdo_gl.bench.measure import (
    BenchRenderer,
    ErrorPanel,
    Goal,
    ReferenceCache,
    fingerprint,
    judge,
    judged_pixels,
    machine_class,
    obtain,
    panel_named,
    scene_fingerprint,
    shader_fingerprint,
)
from ssdo_gl.bench.presets import PresetRung, read_ladder
from ssdo_gl.bench.statistics import draw, rmse_interval
from ssdo_gl.bench.storage import (
    BenchError,
    read_json,
    replace_json,
    say_not_kept,
    usual_folder,
)
from ssdo_gl.bench.tuning.tune import (
    CALIBRATION_FRAMES,
    CannotTuneError,
    Choice,
    check_usable,
    opened,
)
from ssdo_gl.gpu.context import Device
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.methods import METHODS

# Errors are calibrated on a smaller frame: a reference of the whole one would take minutes.
# A larger frame shows more detail, so errors there are smaller, not larger.
CALIBRATION_PIXELS = 320 * 180
CALIBRATION_SPP = 16
CALIBRATION_SEEDS = 2
# The reference's standard error for the calibration, relative to the mean; it is subtracted,
# so what is left of it is far smaller. Errors of all light are smaller, too.
CALIBRATION_GOALS = {"near": 0.03, "gi": 0.01}
CALIBRATION_SECONDS = 20.0
# What an error is relative to.
MEANS = {"near": "the mean", "gi": "the mean of all light"}
# What is said to be measured again next time, where the cache cannot be written.
_WHAT = "measured errors"


@dataclass(frozen=True)
class MethodRung:
    """A method at a rung of the ladder."""

    method: str
    rung: PresetRung
    label: str

    def applied(self, settings: Settings) -> Settings:
        """Return `settings` as this candidate has them."""
        return self.rung.applied(dataclasses.replace(settings, method=self.method, estimator=None))


def candidates(methods: Sequence[str], rungs: Sequence[PresetRung]) -> list[MethodRung]:
    """Return every method at every rung, from cheap to dear within a method."""

    def label(method: str, rung: PresetRung) -> str:
        return rung.label if len(methods) == 1 else f"{method} {rung.label}"

    return [MethodRung(method, rung, label(method, rung)) for method in methods for rung in rungs]


def panel_for(settings: Settings, against: str | None) -> ErrorPanel:
    """Return the panel that errors are measured in: the one that is named, or the method's.

    Raises
    ------
    CannotTuneError
    """
    is_all_light = METHODS[settings.method].is_all_light
    panel = panel_named(against or ("gi" if is_all_light else "near"))
    if is_all_light and not panel.is_all_light and settings.gives("method"):
        raise CannotTuneError(
            f"--truth {against}: --method {settings.method} shows light that the near field lacks; "
            "use --truth gi"
        )
    return panel


def methods_for(settings: Settings, panel: ErrorPanel) -> tuple[str, ...]:
    """Return the methods to choose among: the one asked for, else all that show it."""
    if settings.gives("method"):
        return (settings.method,)
    if not panel.is_all_light:
        return ("bounce",)
    return tuple(name for name, method in METHODS.items() if method.estimates == "light")


def choose_for_error(
    scene: Scene,
    settings: Settings,
    max_error: float,
    *,
    against: str | None = None,
    camera: Camera | None = None,
    backend: str = "auto",
    device: Device | None = None,
    allow_rays: bool = True,
) -> Choice:
    """Return the cheapest measured setting whose error is at most `max_error`.

    The error is RMSE over the mean of a reference, measured on this scene.

    Parameters
    ----------
    max_error : float
        Relative, > 0: 0.05 is five percent of the mean.
    against : str or None
        ``near``, the near-field reference, or ``gi``, path tracing. None: what the method
        is to show.
    allow_rays : bool
        Whether the reference itself may be chosen where no screen-space setting is
        accurate enough; for a window it may not.

    Raises
    ------
    CannotTuneError, ContextError
    """
    if not (max_error > 0.0 and math.isfinite(max_error)):
        raise CannotTuneError(f"--max-error {max_error:g}: must be a positive number")
    check_usable(settings)
    panel = panel_for(settings, against)
    found = candidates(methods_for(settings, panel), read_ladder().rungs)
    with opened(scene, settings, camera, backend, device) as (renderer, base):
        folder = usual_folder("calibration", _WHAT)
        key = fingerprint(
            "errors",
            machine_class(renderer.device),
            scene_fingerprint(renderer.scene),
            dataclasses.replace(base, seed=0),
            shader_fingerprint(("",)),
            panel.name,
        )
        path = None if folder is None else folder / f"{key}.json"
        errors, how = _kept_errors(path, found), "calibrated before"
        if errors is None:
            start = time.perf_counter()
            errors = measured_errors(renderer, base, panel, found, ReferenceCache())
            how = f"calibrated in {time.perf_counter() - start:.1f} s"
            _keep_errors(path, errors)

        def cost_ms(candidate: MethodRung) -> float:
            single = dataclasses.replace(base, antialias=1)
            times = renderer.timed(candidate.applied(single), ("beauty",), CALIBRATION_FRAMES)
            return times.process_ms if renderer.device.is_software else times.frame_ms

        return within_error(base, max_error, panel, found, errors, how, allow_rays, cost_ms)


def _kept_errors(path: Path | None, chosen: Sequence[MethodRung]) -> dict[str, float] | None:
    """Return what `measured_errors` found of the same candidates before; None if unknown."""
    errors = None if path is None else read_json(path)
    if not isinstance(errors, dict) or set(errors) != {item.label for item in chosen}:
        return None
    are_errors = all(isinstance(e, float) and math.isfinite(e) and e > 0.0 for e in errors.values())
    return errors if are_errors else None


def _keep_errors(path: Path | None, errors: Mapping[str, float]) -> None:
    try:
        if path is not None:
            replace_json(path, errors)
    except BenchError as error:
        say_not_kept(_WHAT, error)


def measured_errors(
    renderer: BenchRenderer,
    settings: Settings,
    panel: ErrorPanel,
    chosen: Sequence[MethodRung],
    cache: ReferenceCache,
) -> dict[str, float]:
    """Return the upper end of each candidate's error interval on this scene, by label.

    The interval is over pixel blocks, so its end allows for views whose content is like
    that of the calibrated one.
    """
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
        Goal(panel.aov, CALIBRATION_GOALS[panel.name], True, CALIBRATION_SECONDS),
        mask,
        cache,
    )
    alone = dataclasses.replace(panel, parts=())
    found = {}
    for candidate in chosen:
        renderings = [
            renderer.images(
                candidate.applied(dataclasses.replace(small, seed=small.seed + seed)), (panel.aov,)
            )
            for seed in range(CALIBRATION_SEEDS)
        ]
        blocks = judge(alone, renderings, reference, mask, 0.0).blocks
        draws = draw(blocks.block_count, blocks.seed_count)
        found[candidate.label] = rmse_interval(blocks, draws, relative=True).high
    return found


def _smaller(size: tuple[int, int]) -> tuple[int, int]:
    """Return a size of the same shape with at most `CALIBRATION_PIXELS` pixels."""
    width, height = size
    factor = min(1.0, math.sqrt(CALIBRATION_PIXELS / (width * height)))
    return max(1, round(width * factor)), max(1, round(height * factor))


def within_error(
    settings: Settings,
    max_error: float,
    panel: ErrorPanel,
    chosen: Sequence[MethodRung],
    errors: Mapping[str, float],
    how: str,
    allow_rays: bool,
    cost_ms: Callable[[MethodRung], float],
) -> Choice:
    """Return the cheapest candidate whose error is surely small enough.

    Parameters
    ----------
    how : str
        Where the errors come from.
    cost_ms : callable
        What a frame takes; asked for one candidate of each method, if several will do.
    """
    mean = MEANS[panel.name]
    # Of each method the first that will do: within one, the ladder knows the order.
    fitting = {c.method: c for c in reversed(chosen) if errors[c.label] <= max_error}
    if fitting:
        costs = {c.label: cost_ms(c) for c in fitting.values()} if len(fitting) > 1 else {}
        best = min(fitting.values(), key=lambda c: costs.get(c.label, 0.0))
        expected = errors[best.label]
        sentence = (
            f"chose {best.label}: error at most {percent(expected)} of {mean}, "
            f"{percent(max_error)} allowed ({how})"
        )
        times = [f"{name} {ms:.1f} ms" for name, ms in costs.items()]
        sentence += f"; a frame takes {', '.join(times)}" if times else ""
        return Choice(best.applied(settings), sentence, True, error=expected)
    best = min(chosen, key=lambda c: errors[c.label])
    reached = percent(errors[best.label])
    if allow_rays:
        traced = dataclasses.replace(
            settings, method=panel.method, estimator=None, max_error=max_error
        ).checked()
        sentence = (
            f"chose rays ({panel.method}): no screen-space setting is within "
            f"{percent(max_error)} of {mean}; the best, {best.label}, reaches {reached} ({how})"
        )
        return Choice(traced, sentence, True, error=max_error)
    sentence = (
        f"no measured setting is within {percent(max_error)} of {mean}: the most accurate, "
        f"{best.label}, reaches {reached} ({how})"
    )
    return Choice(best.applied(settings), sentence, False, error=errors[best.label])
