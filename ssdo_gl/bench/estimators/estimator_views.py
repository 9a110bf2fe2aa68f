"""What every estimator finds and takes, in views of scenes: visibility and light."""

from __future__ import annotations

import dataclasses
import itertools
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.bench.bench_workers import spread
from ssdo_gl.bench.measure import (
    CLOCK_NAMES,
    BenchRenderer,
    ErrorPanel,
    Goal,
    Images,
    Judged,
    Point,
    Reference,
    ReferenceCache,
    color,
    describe_machine,
    judge,
    judged_pixels,
    obtain,
    order,
    render_seeds,
    trusted_clock,
    unit_px,
)
from ssdo_gl.bench.storage import BenchError
from ssdo_gl.gpu.context import Device
from ssdo_gl.images.error import Mask, mean_level
from ssdo_gl.progress import StageProgress
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.estimators import ESTIMATORS
from ssdo_gl.settings.methods import METHODS

# Radii on the screen, pixels: the mean over what is in view.
RADII_PX = (10.0, 40.0, 160.0)
BUDGETS = (8, 16, 32, 64)
STEPS = (2, 4, 8)
FILTERS = ("none", "edge")
SEEDS, ROUNDS, FRAMES = 3, 2, 2
REFERENCE_SPP, REFERENCE_SECONDS = 128, 30.0
# Standard errors: of visibility; of light, relative to its mean.
REFERENCE_ERROR, RELATIVE_ERROR = 0.004, 0.01


@dataclass(frozen=True)
class Quantity:
    """What estimators find: an image, by which method, held to which reference.

    Attributes
    ----------
    unit : (estimator, reads, filter)
        The setting that times are multiples of.
    radii_px : tuple of float
        Where it is measured.
    """

    aov: str
    method: str
    reference: str
    unit: tuple[str, int, str]
    radii_px: tuple[float, ...]

    @property
    def panel(self) -> ErrorPanel:
        """How an image is held to the reference."""
        return ErrorPanel(self.aov, self.reference, self.aov, self.aov, "")

    def normalised(self, images: Images, level: float) -> dict[str, NDArray[np.float32]]:
        """Return the image alone, as a multiple of `level`: light has no unit of its own."""
        return {self.aov: color(images[self.aov]) / np.float32(level)}


QUANTITIES = (
    Quantity("visibility", "ssao", "reference-ao", ("hemisphere", 16, "edge"), RADII_PX),
    Quantity("directional", "bounce", "reference-near", ("rgs09", 16, "edge"), (40.0,)),
    Quantity("bounce", "bounce", "reference-near", ("rgs09", 16, "edge"), (40.0,)),
)


@dataclass(frozen=True, kw_only=True)
class TablePlan:
    """How much is measured."""

    radii_px: Sequence[float] = RADII_PX
    budgets: Sequence[int] = BUDGETS
    steps: Sequence[int] = STEPS
    seeds: int = SEEDS
    rounds: int = ROUNDS
    reference_seconds: float = REFERENCE_SECONDS


QUICK = TablePlan(
    radii_px=(10.0, 40.0), budgets=(16,), steps=(4,), seeds=2, rounds=2, reference_seconds=10.0
)


@dataclass(frozen=True, eq=False)
class Measured:
    """One point in one view: errors, and milliseconds by round."""

    judged: Judged
    ms: NDArray[np.float64]


ViewTable = Mapping[tuple[str, float], Mapping[Point, Measured]]
# What is measured, by name: scenes, and what holds for all their points.
Subjects = Mapping[str, tuple[Scene, Settings]]


def points_of(plan: TablePlan, quantity: Quantity) -> list[Point]:
    """Return every combination that differs."""
    found: dict[tuple[object, ...], Point] = {}
    for name, samples, steps, smoothing in itertools.product(
        METHODS[quantity.method].estimators, plan.budgets, plan.steps, FILTERS
    ):
        key = (name, *ESTIMATORS[name].shared_out(samples, steps), smoothing, samples)
        point = Point(quantity.aov, name, quantity.method, name, samples, steps)
        found.setdefault(key, dataclasses.replace(point, filter=smoothing))
    return list(found.values())


def milliseconds(renderer: BenchRenderer, point: Point, base: Settings, clock: str) -> float:
    """Return what a point takes beyond the G-buffer."""
    times = dict(renderer.split(point.settings(base), point.wanted, FRAMES, clock))
    return sum(ms for name, ms in times.items() if name != "gbuffer")


def _traced(
    renderer: BenchRenderer, base: Settings, method: str, seconds: float, mask: Mask
) -> Reference:
    """Return the reference of every quantity that is held to `method`."""
    aovs = [quantity.aov for quantity in QUANTITIES if quantity.reference == method]
    traced = dataclasses.replace(base, method=method, spp=REFERENCE_SPP)
    goal = Goal("visibility", REFERENCE_ERROR, False, seconds)
    if "visibility" not in aovs:
        goal = Goal(aovs[-1], RELATIVE_ERROR, True, seconds)
    with tempfile.TemporaryDirectory() as folder:
        return obtain(renderer, traced, aovs, goal, mask, ReferenceCache(Path(folder)))


def _normalised(
    quantity: Quantity, reference: Reference, mask: Mask
) -> tuple[Reference, float] | None:
    """Return a reference whose errors are relative, and by what; None where it is black."""
    if quantity.aov == "visibility":
        return reference, 1.0
    level = mean_level(color(reference.images[quantity.aov]), mask)
    if level == 0.0:
        return None
    images = quantity.normalised(reference.images, level)
    variance = quantity.normalised(reference.variance, level**2)
    return dataclasses.replace(reference, images=images, variance=variance), level


@dataclass(frozen=True, eq=False)
class _PointErrors:
    """Measures the errors of a point; plain data, which workers get."""

    base: Settings
    quantity: Quantity
    reference: Reference
    level: float
    mask: Mask
    seeds: int

    def __call__(self, renderer: BenchRenderer, point: Point) -> Judged:
        aov = self.quantity.aov
        seeds = render_seeds(renderer, point, self.base, self.seeds, (aov,))
        images = [self.quantity.normalised(image, self.level) for image in seeds]
        return judge(self.quantity.panel, images, self.reference, self.mask, 0.0)


def errors_in(
    renderer: BenchRenderer, base: Settings, radius_px: float, plan: TablePlan
) -> dict[Point, Judged]:
    """Return errors of all points in one view; `base` has its radius."""
    mask, references = judged_pixels(renderer, base), {}
    judged: dict[Point, Judged] = {}
    for quantity in QUANTITIES:
        if radius_px not in quantity.radii_px:
            continue
        if quantity.reference not in references:
            seconds = plan.reference_seconds
            references[quantity.reference] = _traced(
                renderer, base, quantity.reference, seconds, mask
            )
        found = _normalised(quantity, references[quantity.reference], mask)
        if found is None:
            continue
        reference, level = found
        judging = _PointErrors(base, quantity, reference, level, mask, plan.seeds)
        points = points_of(plan, quantity)
        judged.update(zip(points, renderer.each(judging, points), strict=True))
    return judged


def with_times(
    renderer: BenchRenderer,
    judged: Mapping[Point, Judged],
    base: Settings,
    plan: TablePlan,
    clock: str,
) -> dict[Point, Measured]:
    """Return errors and times of all points in one view that take time."""
    points = list(judged)
    times = np.zeros((len(points), plan.rounds))
    for number in range(plan.rounds):
        for index in order(number, len(points)):
            times[index, number] = milliseconds(renderer, points[index], base, clock)
    view = {point: Measured(judged[point], times[index]) for index, point in enumerate(points)}
    # Where no pass runs, because nothing can block, there is nothing to compare.
    kinds = {point.kind for point in points}
    running = {q.aov for q in QUANTITIES if q.aov in kinds and unit_of(view, q).any()}
    return {point: measured for point, measured in view.items() if point.kind in running}


def measure(
    subjects: Subjects,
    plan: TablePlan,
    device: Device,
    progress: StageProgress,
    scheduler: str | None = None,
) -> tuple[ViewTable, list[str]]:
    """Return every view's measurements, and how they were made, in words.

    Workers of `scheduler`, if any, make errors; times are measured here, after them.
    """
    views: dict[tuple[str, float], Mapping[Point, Measured]] = {}
    how: list[str] = []
    for name, (scene, settings) in subjects.items():
        with Renderer(scene, settings, device=device) as r:
            clock = trusted_clock(describe_machine(device, r.timer_kind, ""))
            renderer = BenchRenderer(r)
            base = dataclasses.replace(r.settings, antialias=1, estimator=None, max_error=None)
            mask = judged_pixels(renderer, base)
            if not mask.any():
                raise BenchError("the camera sees no surface: there is nothing to measure")
            unit = unit_px(renderer, base, mask)
            bases = {px: dataclasses.replace(base, radius=px / unit) for px in plan.radii_px}
            judged = {}
            with spread(renderer, scheduler) as (maker, sentence):
                for radius_px, at in bases.items():
                    progress.say(f"{name}, R of {radius_px:g} px")
                    judged[radius_px] = errors_in(maker, at, radius_px, plan)
            for radius_px, at in bases.items():
                progress.say(f"{name}, R of {radius_px:g} px, times")
                views[name, radius_px] = with_times(renderer, judged[radius_px], at, plan, clock)
            how = [f"{plan.rounds} rounds by {CLOCK_NAMES[clock]}", *filter(None, [sentence])]
    if not any(views.values()):
        raise BenchError("nothing in view blocks anything: every estimator is exact, and none runs")
    return views, how


def unit_of(view: Mapping[Point, Measured], quantity: Quantity) -> NDArray[np.float64]:
    """Return the milliseconds by round that times are multiples of."""
    return next(
        m.ms
        for p, m in view.items()
        if (p.kind, p.estimator, p.samples, p.filter) == (quantity.aov, *quantity.unit)
    )
