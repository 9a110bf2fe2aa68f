"""The truths of one bench: refined until they are worth ten times what is judged by them."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ssdo_gl.bench.analysis import Result, TruthSummary
from ssdo_gl.bench.bootstrap import replicas_of_relative_rmse, replicas_of_rmse, whole
from ssdo_gl.bench.errors import (
    PANELS,
    Judged,
    Panel,
    Scalars,
    judge,
    panel_named,
    render_seeds,
    wanted_images,
)
from ssdo_gl.bench.metrics import Mask
from ssdo_gl.bench.points import Point
from ssdo_gl.bench.progress import BenchProgress
from ssdo_gl.bench.renderings import Images, Studio
from ssdo_gl.bench.truth import Accumulator, Goal, Truth, TruthCache, obtain, truth_key
from ssdo_gl.settings import Settings

# The converged march: what is left of its error is what one camera layer does not show.
LIMITS = {
    "radiance": Point("radiance", "limit", "bounce", "march", 1024, 32, 1.0, "none"),
    "visibility": Point("visibility", "limit", "ssao", "march", 1024, 32, 1.0, "none"),
}
# A truth's standard error aims at this part of the smallest error reported.
TRUTH_RATIO = 0.1
# The goal before any error is known: enough to estimate the smallest one to a few percent.
FIRST_GOAL = 0.03
# Where a scene leaves the screen nothing to miss, the limit's error is only its noise; no
# one sees an error below this.
SMALLEST_FLOOR = 1e-3


@dataclass(frozen=True)
class TruthRequest:
    """What truths are wanted.

    Attributes
    ----------
    mask : ndarray of bool
        Pixels that count.
    kinds : sequence of str
        Kinds of points that will be judged.
    seeds : int
        Sample patterns of the limit.
    batch_spp : int
        Samples per pixel of one independent batch.
    max_seconds : float
        For each truth, in this call.
    renderer : str
        Part of the key under which truths are cached.
    smallest : mapping
        The smallest error seen so far, by panel name; empty before anything was judged.
    """

    studio: Studio
    base: Settings
    mask: Mask
    kinds: Sequence[str]
    seeds: int
    batch_spp: int
    max_seconds: float
    renderer: str
    smallest: Mapping[str, float] = field(default_factory=dict)
    cache: TruthCache = field(default_factory=TruthCache)


@dataclass(frozen=True)
class Standards:
    """What points are held to, by panel name.

    Attributes
    ----------
    truths : dict of str to Truth
    floors : dict of str to Scalars
        What the converged march loses to each truth.
    limits : dict of str to Truth
        The converged march itself, averaged over its seeds.
    """

    truths: dict[str, Truth]
    floors: dict[str, Scalars]
    limits: dict[str, Truth]


def make_standards(request: TruthRequest, progress: BenchProgress) -> Standards:
    """Return truths, refined as far as they must be, and the converged march."""
    found = Standards({}, {}, {})
    for kind in request.kinds:
        panels = [panel for panel in PANELS if panel.kind == kind]
        point = LIMITS[kind]
        renderings = render_seeds(
            request.studio, point, request.base, request.seeds, wanted_images(panels)
        )
        kept = Accumulator()
        for rendering in renderings:
            kept.add(rendering)
        limit = kept.truth(point.samples * request.seeds, 0.0)
        for panel in panels:
            truth, floor = make_truth(panel, request, renderings, progress)
            found.truths[panel.name] = truth
            found.floors[panel.name] = floor
            found.limits[panel.name] = limit
    return found


def make_truth(
    panel: Panel, request: TruthRequest, limit: Sequence[Images], progress: BenchProgress
) -> tuple[Truth, Scalars]:
    """Refine a panel's truth until it is worth ten times the error of the `limit`."""
    settings = dataclasses.replace(
        request.base, method=panel.method, estimator=None, spp=request.batch_spp
    )
    wanted = (panel.image, *panel.parts)
    stage = f"truth {panel.method}"

    def batch(seed: int) -> Images:
        return request.studio.images(dataclasses.replace(settings, seed=seed), wanted)

    def report(text: str, share: float) -> None:
        progress.share(stage, f"{stage}: {text}", share)

    key = truth_key(request.studio.scene, settings, request.renderer, wanted)
    target, deadline = FIRST_GOAL, time.perf_counter() + request.max_seconds
    while True:
        seconds = max(0.0, deadline - time.perf_counter())
        goal = Goal(panel.image, target, panel.relative, seconds)
        truth = obtain(key, [goal], request.mask, batch, request.batch_spp, request.cache, report)
        verdict = judge(panel, limit, truth, request.mask, request.base.exposure or 0.0)
        smallest = min(verdict.scalars.systematic, request.smallest.get(panel.name, math.inf))
        wanted_error = TRUTH_RATIO * max(smallest, SMALLEST_FLOOR)
        # The limit's own error is known better with each refinement: it may settle below
        # what the goal was derived from, but never by much.
        if not goal.reached(truth, request.mask) or wanted_error >= target:
            return truth, verdict.scalars
        target = wanted_error


def smallest_errors(
    judged: Mapping[str, Mapping[str, Judged]],
) -> dict[str, float]:
    """Return the smallest error measured against each truth, by panel name."""
    found: dict[str, float] = {}
    for verdicts in judged.values():
        for name, item in verdicts.items():
            of = replicas_of_relative_rmse if panel_named(name).relative else replicas_of_rmse
            error = float(of(item.blocks, whole(item.blocks))[0])
            found[name] = min(error, found.get(name, math.inf))
    return found


def good_enough(truths: Mapping[str, Truth], smallest: Mapping[str, float], mask: Mask) -> bool:
    """Whether every truth is worth ten times the smallest error measured against it."""
    for name, error in smallest.items():
        panel = panel_named(name)
        goal = Goal(panel.image, TRUTH_RATIO * max(error, SMALLEST_FLOOR), panel.relative, 0.0)
        if not goal.reached(truths[name], mask):
            return False
    return True


def summaries(
    results: Sequence[Result], standards: Standards, mask: Mask
) -> dict[str, TruthSummary]:
    """Return what every truth is worth, by panel name."""
    found = {}
    for panel in PANELS:
        truth = standards.truths.get(panel.name)
        errors = [r.verdicts[panel.name].error.value for r in results if panel.name in r.verdicts]
        if truth is None or not errors:
            continue
        of = truth.relative_standard_error if panel.relative else truth.standard_error
        found[panel.name] = TruthSummary(
            panel.name,
            panel.method,
            truth.spp,
            truth.batches,
            truth.seconds,
            of(panel.image, mask),
            min(errors),
            standards.floors[panel.name].systematic,
            standards.floors[panel.name].parts,
        )
    return found
