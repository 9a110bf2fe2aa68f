"""Runs a whole bench: references, errors, times, then tables, plots and report."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rich.console import Console

from ssdo_gl.bench import analysis, report
from ssdo_gl.bench.analysis import Result
from ssdo_gl.bench.bench_data import Bench
from ssdo_gl.bench.measure import (
    BenchRenderer,
    Judged,
    Point,
    describe_machine,
    judged_pixels,
    read_grid,
    tabulate,
    time_points,
    trusted_clock,
    unit_px,
)
from ssdo_gl.bench.references import (
    ReferenceRequest,
    ReferenceSet,
    good_enough,
    make_references,
    smallest_errors,
    summaries,
)
from ssdo_gl.bench.storage import ROUNDS, BenchError, claim_folder, csv_bytes, replace_file
from ssdo_gl.effects.far_field import FarField
from ssdo_gl.gpu.context import create_context
from ssdo_gl.images.error import Mask
from ssdo_gl.progress import StageProgress, stage_progress
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.methods import METHODS

QUICK_SIZE, FULL_SIZE = (320, 180), (640, 360)


@dataclass(frozen=True)
class BenchPlan:
    """How much is measured.

    Attributes
    ----------
    rounds, frames : int
        Visits to each point, and warm frames in each.
    seeds : int
        Sample patterns whose errors are averaged.
    reference_seconds : float
        At most this long for each reference, in one run.
    batch_spp : int
        Samples per pixel of one independent batch of a reference.
    """

    rounds: int
    frames: int
    seeds: int
    reference_seconds: float
    batch_spp: int


QUICK = BenchPlan(3, 3, 2, 15.0, 64)
FULL = BenchPlan(7, 5, 4, 900.0, 256)


def bench_size(quick: bool) -> tuple[int, int]:
    """Return the picture size of a bench for which the user named none."""
    return QUICK_SIZE if quick else FULL_SIZE


def points_of_bench(quick: bool) -> list[Point]:
    """Return what a bench measures."""
    return [point for point in read_grid() if point.quick or not quick]


def run_bench(
    scene_source: str,
    settings: Settings,
    outdir: Path,
    *,
    quick: bool = False,
    scene: Scene | None = None,
    camera: Camera | None = None,
    backend: str = "auto",
    command: str = "",
    quiet: bool = False,
    plan: BenchPlan | None = None,
) -> Bench:
    """Measure error against time for a scene and write tables, plots and the report.

    Parameters
    ----------
    scene_source : str
        A scene file, a model file or the name of a built-in scene.
    settings : Settings
        Size, radius, shadows, exposure and seed hold; method, estimator and the other
        axes of the grid are what is varied.
    outdir : Path
        Receives report, tables, plots and raw measurements.
    quick : bool
        A smaller grid and shorter references: two minutes, five of half a million triangles.
    scene : Scene or None
        What `scene_source` names, if it is loaded already.
    camera : Camera or None
        Replaces the scene's camera.
    command : str
        What the user typed, for the report.

    Raises
    ------
    BenchError, MissingLibraryError, SceneError, SettingError, ContextError
    """
    report.check_libraries()
    scene = scene or load_scene(scene_source)
    if camera is not None:
        scene = dataclasses.replace(scene, camera=camera)
    plan, points = plan or (QUICK if quick else FULL), points_of_bench(quick)
    claim_folder(outdir)
    device = create_context(backend)
    try:
        with stage_progress(quiet=quiet) as progress, Renderer(scene, settings, device=device) as r:
            base = dataclasses.replace(r.settings, antialias=1, estimator=None, max_error=None)
            machine = describe_machine(device, r.timer_kind, command)
            own = BenchRenderer(r)
            run = BenchRun(own, base, points, plan, quick, outdir, progress, camera)
            run.leave_out_needless()
            bench = run.measure(scene_source, machine)
            progress.say("writing tables, plots and report ...")
            report.write_report(bench, outdir)
    finally:
        device.release()
    if not quiet:
        report.print_outcome(bench, outdir, Console(highlight=False, soft_wrap=True))
    return bench


@dataclass
class BenchRun:
    """One bench in progress: what its stages share."""

    renderer: BenchRenderer
    base: Settings
    points: Sequence[Point]
    plan: BenchPlan
    quick: bool
    outdir: Path
    progress: StageProgress
    camera: Camera | None = None
    notes: list[str] = field(default_factory=list)

    def leave_out_needless(self) -> None:
        """Leave out points of all light where none comes from beyond R, and note why."""
        needless = [p for p in self.points if METHODS[p.method].is_all_light and p.estimator]
        if not needless:
            return
        reason = self.renderer.why_spared(needless[0].settings(self.base), FarField.title)
        if reason is not None:
            self.points = [p for p in self.points if p not in needless]
            self.notes.append(f"gi is not measured, as nothing comes from beyond R: {reason}.")

    def measure(self, source: str, machine: Mapping[str, Any]) -> Bench:
        """Carry out every stage and return what was found."""
        clock = self._clock(machine)
        mask = self._mask()
        references, judged = self._judged(mask)
        by_panel = references.by_panel
        rows = time_points(
            self.renderer,
            self.points,
            self.base,
            self.plan.rounds,
            self.plan.frames,
            self.progress.steps,
        )
        replace_file(self.outdir / ROUNDS, csv_bytes([dataclasses.asdict(row) for row in rows]))
        table = tabulate(rows, self.points, self.plan.rounds, clock)
        results = analysis.analyse(self.points, table, judged)
        recommendation = analysis.recommend(results)
        chosen = report.chosen_results(results, recommendation)
        radius_px = (self.base.radius or 0.0) * unit_px(self.renderer, self.base, mask)
        bench = Bench(
            scene=source,
            title=self.renderer.scene.title or source,
            scene_settings=self.renderer.scene.render,
            camera=self.camera,
            base=self.base,
            radius_px=radius_px,
            triangles=self.renderer.scene.triangle_count,
            quick=self.quick,
            seeds=self.plan.seeds,
            rounds=self.plan.rounds,
            frames=self.plan.frames,
            clock=clock,
            drift=tuple(float(value) for value in table.drift),
            machine=dict(machine),
            results=results,
            references=summaries(results, references, mask),
            recommendation=recommendation,
            pictures=report.take_pictures(
                self.renderer, self.base, chosen, by_panel, mask, self.progress.steps
            ),
            notes=tuple(self.notes),
        )
        return dataclasses.replace(bench, splits=self._splits(report.split_results(bench), clock))

    def _clock(self, machine: Mapping[str, Any]) -> str:
        """Return what to time by, and note why if it is not the usual."""
        clock = trusted_clock(machine)
        if clock == "process":
            self.notes.append(
                f"The machine was busy when this began (load {machine['load']:.1f} on "
                f"{machine['cores']} cores), so times are processor times, which are surer but "
                "longer than a frame takes."
            )
        return clock

    def _mask(self) -> Mask:
        mask = judged_pixels(self.renderer, self.base)
        if not mask.any():
            raise BenchError("the camera sees no surface: there is nothing to measure")
        return mask

    def _judged(self, mask: Mask) -> tuple[ReferenceSet, dict[str, dict[str, Judged]]]:
        """Return what points are held to, and every point's errors."""
        request = ReferenceRequest(
            self.renderer,
            self.base,
            mask,
            sorted({point.kind for point in self.points}),
            self.plan.seeds,
            self.plan.batch_spp,
            self.plan.reference_seconds,
        )
        references = make_references(request, self.progress)
        judged = self._errors(references, mask)
        smallest = smallest_errors(judged)
        if not self.quick and not good_enough(references.by_panel, smallest, mask):
            # A setting came closer to a reference than the converged march did.
            request = dataclasses.replace(request, smallest=smallest)
            references = make_references(request, self.progress)
            judged = self._errors(references, mask)
        return references, judged

    def _errors(self, references: ReferenceSet, mask: Mask) -> dict[str, dict[str, Judged]]:
        """Return the errors of every point against every reference it can be held to."""
        judged = {}
        for done, point in enumerate(self.points, 1):
            judged[point.key] = references.errors_of(
                self.renderer, point, self.base, mask, self.plan.seeds
            )
            self.progress.steps("errors", done, len(self.points))
        return judged

    def _splits(
        self, results: Sequence[Result], clock: str
    ) -> dict[str, tuple[tuple[str, float], ...]]:
        """Return where the time of some points goes."""
        splits = {}
        for done, result in enumerate(results, 1):
            point = result.point
            splits[point.key] = self.renderer.split(
                point.settings(self.base), point.wanted, self.plan.frames, clock
            )
            self.progress.steps("pass times", done, len(results))
        return splits
