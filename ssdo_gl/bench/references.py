"""The references of one bench: refined until they are worth ten times what is judged by them."""

from __future__ import annotations

import dataclasses
import itertools
import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ssdo_gl.bench.analysis import ReferenceSummary, Result
from ssdo_gl.bench.measure import (
    Accumulator,
    BenchRenderer,
    ErrorPanel,
    Goal,
    Images,
    Judged,
    Point,
    Reference,
    ReferenceCache,
    Scalars,
    all_aovs,
    error_panels,
    judge,
    obtain,
    panel_named,
    render_seeds,
    screen_space_method,
)
from ssdo_gl.bench.statistics import rmse_of
from ssdo_gl.images.error import Mask
from ssdo_gl.progress import StageProgress
from ssdo_gl.settings import Settings

# A reference's standard error aims at this part of the smallest error reported.
REFERENCE_RATIO = 0.1
# The goal before any error is known: enough to estimate the smallest one to a few percent.
FIRST_GOAL = 0.03
# Where a scene leaves the screen nothing to miss, the limit's error is only its noise; no
# one sees an error below this.
SMALLEST_FLOOR = 1e-3


@dataclass(frozen=True)
class ReferenceRequest:
    """What references are wanted.

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
        For each reference, in this call.
    smallest : mapping
        The smallest error seen so far, by panel name; empty before anything was judged.
    """

    renderer: BenchRenderer
    base: Settings
    mask: Mask
    kinds: Sequence[str]
    seeds: int
    batch_spp: int
    max_seconds: float
    smallest: Mapping[str, float] = field(default_factory=dict)
    cache: ReferenceCache = field(default_factory=ReferenceCache)


@dataclass(frozen=True)
class ReferenceSet:
    """What points are held to, by panel name.

    Attributes
    ----------
    floors : dict of str to Scalars
        What the converged march loses to each reference.
    limits : dict of str to Reference
        The converged march itself, averaged over its seeds; with light from beyond R where
        the reference has that.
    """

    by_panel: dict[str, Reference]
    floors: dict[str, Scalars]
    limits: dict[str, Reference]


def converged_march(panel: ErrorPanel) -> Point:
    """Return a point whose error is what one camera layer does not show, and shadow maps."""
    method = screen_space_method(panel.kind, all_light=panel.is_all_light)
    return Point(panel.kind, "limit", method, "march", 1024, 32, 1.0, "none")


def make_references(request: ReferenceRequest, progress: StageProgress) -> ReferenceSet:
    """Return references, refined as far as they must be, and the converged march."""
    found = ReferenceSet({}, {}, {})
    panels = [panel for panel in error_panels() if panel.kind in request.kinds]
    for point, group in itertools.groupby(panels, converged_march):
        alike = list(group)
        renderings = render_seeds(
            request.renderer, point, request.base, request.seeds, all_aovs(alike)
        )
        kept = Accumulator()
        for rendering in renderings:
            kept.add(rendering)
        limit = kept.reference(point.samples * request.seeds, 0.0)
        for panel in alike:
            reference, floor = make_reference(panel, request, renderings, progress)
            found.by_panel[panel.name] = reference
            found.floors[panel.name] = floor
            found.limits[panel.name] = limit
    return found


def make_reference(
    panel: ErrorPanel, request: ReferenceRequest, limit: Sequence[Images], progress: StageProgress
) -> tuple[Reference, Scalars]:
    """Refine a panel's reference until it is worth ten times the error of the `limit`."""
    settings = dataclasses.replace(request.base, method=panel.method, spp=request.batch_spp)
    stage = f"reference {panel.method}"

    def report(text: str, share: float) -> None:
        progress.share(stage, f"{stage}: {text}", share)

    target, deadline = FIRST_GOAL, time.perf_counter() + request.max_seconds
    while True:
        seconds = max(0.0, deadline - time.perf_counter())
        goal = Goal(panel.aov, target, panel.relative, seconds)
        reference = obtain(
            request.renderer, settings, panel.aovs, goal, request.mask, request.cache, report
        )
        verdict = judge(panel, limit, reference, request.mask, request.base.exposure or 0.0)
        smallest = min(verdict.scalars.systematic, request.smallest.get(panel.name, math.inf))
        wanted_error = REFERENCE_RATIO * max(smallest, SMALLEST_FLOOR)
        # The limit's own error is known better with each refinement: it may settle below
        # what the goal was derived from, but never by much.
        if not goal.reached(reference, request.mask) or wanted_error >= target:
            return reference, verdict.scalars
        target = wanted_error


def smallest_errors(
    judged: Mapping[str, Mapping[str, Judged]],
) -> dict[str, float]:
    """Return the smallest error measured against each reference, by panel name."""
    found: dict[str, float] = {}
    for verdicts in judged.values():
        for name, item in verdicts.items():
            error = rmse_of(item.blocks, relative=panel_named(name).relative)
            found[name] = min(error, found.get(name, math.inf))
    return found


def good_enough(
    references: Mapping[str, Reference], smallest: Mapping[str, float], mask: Mask
) -> bool:
    """Whether every reference is worth ten times the smallest error measured against it."""
    for name, error in smallest.items():
        panel = panel_named(name)
        goal = Goal(panel.aov, REFERENCE_RATIO * max(error, SMALLEST_FLOOR), panel.relative, 0.0)
        if not goal.reached(references[name], mask):
            return False
    return True


def summaries(
    results: Sequence[Result], references: ReferenceSet, mask: Mask
) -> dict[str, ReferenceSummary]:
    """Return what every reference is worth, by panel name."""
    found = {}
    for panel in error_panels():
        reference = references.by_panel.get(panel.name)
        errors = [r.verdicts[panel.name].error.value for r in results if panel.name in r.verdicts]
        if reference is None or not errors:
            continue
        of = reference.relative_standard_error if panel.relative else reference.standard_error
        found[panel.name] = ReferenceSummary(
            panel.name,
            panel.method,
            reference.spp,
            reference.batches,
            reference.seconds,
            of(panel.aov, mask),
            min(errors),
            references.floors[panel.name].systematic,
            references.floors[panel.name].parts,
        )
    return found
