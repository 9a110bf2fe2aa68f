"""Error against time of every estimator, budget, split, filter and radius.

``ssdo-gl SCENE --bench OUTDIR --estimators`` writes into OUTDIR

- ``estimators.csv``: every combination by scene and radius: error, noise, fault, bias, time;
- ``estimators.md``: by quantity, radius and filter, each estimator's best split of each budget,
  averaged over the scenes, with confidence; and which of them nothing beats;
- ``estimators.png``: the same as charts.

Time is that of all passes which the quantity takes beyond the G-buffer, as a multiple of its
`Quantity.unit` in the same round; errors of light are relative to the mean of the reference.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.bench.estimators.estimator_views import (
    FILTERS,
    QUANTITIES,
    QUICK,
    RADII_PX,
    Measured,
    Quantity,
    Subjects,
    TablePlan,
    ViewTable,
    measure,
    unit_of,
)
from ssdo_gl.bench.measure import Point
from ssdo_gl.bench.report import COLORS, MARKERS, as_bytes, check_libraries, drawn_in_style
from ssdo_gl.bench.statistics import (
    bias_replicas,
    draw,
    membership,
    pareto_front,
    rmse_replicas,
    whole,
)
from ssdo_gl.bench.storage import BenchError, claimed_folder, csv_bytes, replace_file
from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.progress import StageProgress, stage_progress
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.estimators import ESTIMATORS

REPLICAS = 500


@dataclass(frozen=True, eq=False)
class Averaged:
    """One point at one radius, averaged over scenes."""

    point: Point
    error: float
    error_replicas: NDArray[np.float64]
    noise: float
    fault: float
    bias: float
    time: float
    time_replicas: NDArray[np.float64]

    @property
    def interval(self) -> tuple[float, float]:
        """Within which the error lies with 95 % confidence."""
        low, high = np.percentile(self.error_replicas, [2.5, 97.5])
        return float(low), float(high)


def averaged(
    point: Point, quantity: Quantity, views: Sequence[Mapping[Point, Measured]]
) -> Averaged:
    """Average over scenes; each is drawn again by blocks and seeds, times by rounds."""
    rng = np.random.default_rng(0)
    errors, times = [], []
    for view in views:
        blocks = view[point].judged.blocks
        draws = draw(blocks.block_count, blocks.seed_count, REPLICAS, rng)
        errors.append(rmse_replicas(blocks, draws, relative=False))
        times.append(np.log(view[point].ms / unit_of(view, quantity)))
    scalars = [view[point].judged.scalars for view in views]
    all_blocks = [view[point].judged.blocks for view in views]
    log_times = np.mean(times, axis=0)
    rounds = rng.integers(0, len(log_times), (REPLICAS, len(log_times)))
    return Averaged(
        point,
        float(np.mean([rmse_replicas(b, whole(b), relative=False)[0] for b in all_blocks])),
        np.mean(errors, axis=0),
        float(np.mean([s.noise for s in scalars])),
        float(np.mean([s.systematic for s in scalars])),
        float(np.mean([bias_replicas(b, whole(b))[0] for b in all_blocks])),
        float(np.exp(np.median(log_times))),
        np.exp(np.median(log_times[rounds], axis=1)),
    )


def best_splits(rows: Sequence[Averaged]) -> list[Averaged]:
    """Return the most accurate split of each estimator's budgets."""
    groups: dict[tuple[str | None, int], Averaged] = {}
    for row in rows:
        key = row.point.estimator, row.point.samples
        if key not in groups or row.error < groups[key].error:
            groups[key] = row
    return list(groups.values())


def table(rows: Sequence[Averaged]) -> Iterator[str]:
    """Yield a Markdown table, fastest first; what nothing beats is bold."""
    rows = sorted(rows, key=lambda row: row.time)
    on_front = set(pareto_front([r.time for r in rows], [r.error for r in rows]).tolist())
    sure = membership(
        np.stack([r.time_replicas for r in rows], 1), np.stack([r.error_replicas for r in rows], 1)
    )
    yield "| estimator | reads | split | time | error | 95 % | noise | fault | bias | front |"
    yield "|---|---|---|---|---|---|---|---|---|---|"
    for index, row in enumerate(rows):
        name = f"`{row.point.estimator}`"
        estimator = ESTIMATORS[str(row.point.estimator)]
        split = estimator.count_label(row.point.samples, row.point.steps)
        low, high = row.interval
        error = f"**{row.error:.4f}**" if index in on_front else f"{row.error:.4f}"
        yield (
            f"| {name} | {row.point.samples} | {split} | {row.time:.2f} | {error} "
            f"| {low:.3f} to {high:.3f} | {row.noise:.3f} | {row.fault:.3f} "
            f"| {row.bias:+.3f} | {100.0 * sure[index]:.0f} % |"
        )


@dataclass(frozen=True)
class Section:
    """What is compared with each other: best splits at one radius, with one filter."""

    title: str
    rows: list[Averaged]


def _has(view: Mapping[Point, Measured], quantity: Quantity) -> bool:
    return any(point.kind == quantity.aov for point in view)


def sections_of(views: ViewTable, plan: TablePlan) -> Iterator[Section]:
    """Yield the comparisons by quantity, radius and filter."""
    for quantity, radius_px, smoothing in itertools.product(QUANTITIES, plan.radii_px, FILTERS):
        at_radius = [view for (_, radius), view in views.items() if radius == radius_px]
        members = [view for view in at_radius if _has(view, quantity)]
        if members:
            points = [p for p in members[0] if (p.kind, p.filter) == (quantity.aov, smoothing)]
            title = "without filter" if smoothing == "none" else f"{smoothing} filter"
            rows = best_splits([averaged(point, quantity, members) for point in points])
            name = quantity.aov.capitalize()
            yield Section(f"{name}, R of {radius_px:g} pixels, {title}", rows)


def chart(sections: Sequence[Section]) -> Any:
    """Return error against time, a chart for each section."""
    from matplotlib.figure import Figure

    columns = len(FILTERS)
    height = -(-len(sections) // columns)
    figure = Figure(figsize=(5.5 * columns, 3.6 * height), layout="constrained")
    for axes, section in zip(figure.subplots(height, columns).flat, sections, strict=True):
        for number, name in enumerate(ESTIMATORS):
            rows = [row for row in section.rows if row.point.estimator == name]
            rows.sort(key=lambda row: row.point.samples)
            style = {
                "color": COLORS[number % len(COLORS)],
                "marker": MARKERS[number % len(MARKERS)],
            }
            axes.plot([r.time for r in rows], [r.error for r in rows], label=name, **style)
        is_exact = not any(row.error > 0.0 for row in section.rows)
        axes.set(xscale="log", yscale="linear" if is_exact else "log", title=section.title)
        axes.set(xlabel="time, multiples of the unit", ylabel="RMSE")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside right upper", fontsize=7)
    return figure


def csv_rows(views: ViewTable) -> Iterator[dict[str, Any]]:
    """Yield one row for each point of each view."""
    for (scene, radius_px), view in views.items():
        units = {q.aov: float(np.median(unit_of(view, q))) for q in QUANTITIES if _has(view, q)}
        for point, found in view.items():
            blocks, ms, unit = found.judged.blocks, float(np.median(found.ms)), units[point.kind]
            directions, steps = ESTIMATORS[str(point.estimator)].shared_out(
                point.samples, point.steps
            )
            yield {
                "scene": scene,
                "radius_px": radius_px,
                "quantity": point.kind,
                "estimator": point.estimator,
                "samples": point.samples,
                "directions": directions,
                "steps": steps,
                "filter": point.filter,
                "ms": round(ms, 4),
                "time": round(ms / unit, 4) if unit > 0.0 else "",
                "error": round(float(rmse_replicas(blocks, whole(blocks), relative=False)[0]), 5),
                "noise": round(found.judged.scalars.noise, 5),
                "fault": round(found.judged.scalars.systematic, 5),
                "bias": round(float(bias_replicas(blocks, whole(blocks))[0]), 5),
            }


def write(
    outdir: Path,
    subjects: Subjects,
    plan: TablePlan,
    device: Device,
    progress: StageProgress,
    scheduler: str | None = None,
) -> list[dict[str, Any]]:
    """Measure, write the three files and return the rows of the first."""
    outdir.mkdir(parents=True, exist_ok=True)
    views, how = measure(subjects, plan, device, progress, scheduler)
    rows = list(csv_rows(views))
    replace_file(outdir / "estimators.csv", csv_bytes(rows))
    width, height = next(iter(subjects.values()))[1].size
    conditions = f"{device.renderer}; {width}x{height}; {', '.join(subjects)}; "
    conditions += "; ".join([f"{plan.seeds} seeds", *how])
    sections = list(sections_of(views, plan))
    lines = [line for s in sections for line in (f"### {s.title}", "", *table(s.rows), "")]
    replace_file(outdir / "estimators.md", "\n".join([conditions, "", *lines]).encode())
    replace_file(outdir / "estimators.png", as_bytes(drawn_in_style(chart, sections), "png"))
    return rows


def run_estimators(
    scene_source: str,
    settings: Settings,
    outdir: Path,
    *,
    quick: bool,
    scene: Scene,
    camera: Camera | None,
    backend: str,
    scheduler: str | None,
    command: str,
    quiet: bool,
) -> None:
    """Measure one scene for ``--estimators``; parameters as of `ssdo_gl.bench.run.run_bench`.

    Raises
    ------
    BenchError, FarmError, MissingLibraryError, ContextError
    """
    if settings.radius not in (None, scene.render.get("radius")):
        pixels = ", ".join(f"{radius:g}" for radius in RADII_PX)
        raise BenchError(f"--radius has no effect with --estimators: radii are {pixels} pixels")
    check_libraries()
    if camera is not None:
        scene = dataclasses.replace(scene, camera=camera)
    with claimed_folder(outdir), ExitStack() as last:
        device = create_context(backend)
        last.callback(device.release)
        progress = last.enter_context(stage_progress(quiet=quiet))
        plan = QUICK if quick else TablePlan()
        write(outdir, {scene_source: (scene, settings)}, plan, device, progress, scheduler)
    if not quiet:
        print((outdir / "estimators.md").read_text(encoding="utf-8"))
