"""Runs a whole bench: references, errors, times, scaling, then tables, plots and report."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rich.console import Console

from ssdo_gl.bench import analysis, report, scaling
from ssdo_gl.bench.analysis import Result
from ssdo_gl.bench.bench_data import Bench
from ssdo_gl.bench.bench_workers import spread
from ssdo_gl.bench.judging import Judging
from ssdo_gl.bench.measure import (
    ERROR_FORMAT,
    BenchRenderer,
    ErrorStore,
    Judged,
    Point,
    describe_machine,
    fingerprint,
    judged_pixels,
    read_grid,
    scene_fingerprint,
    shader_fingerprint,
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
from ssdo_gl.bench.storage import (
    ERRORS,
    MARKER,
    ROUNDS,
    BenchError,
    claimed_folder,
    holds_bench,
    read_json,
    replace_json,
)
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
from ssdo_gl.version import __version__

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
    flips : tuple of str
        FLIP metrics: ``ldr`` of every point, ``hdr``, which takes seconds, of those whose
        pictures are shown.
    """

    rounds: int
    frames: int
    seeds: int
    reference_seconds: float
    batch_spp: int
    flips: tuple[str, ...]


QUICK = BenchPlan(3, 3, 2, 15.0, 64, flips=("ldr",))
FULL = BenchPlan(7, 5, 4, 900.0, 256, flips=("ldr", "hdr"))


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
    scheduler: str | None = None,
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
        Receives report, tables, plots and raw measurements; an interrupted bench is resumed.
    quick : bool
        A smaller grid and shorter references: two minutes, five of half a million triangles.
    scene : Scene or None
        What `scene_source` names, if it is loaded already.
    camera : Camera or None
        Replaces the scene's camera.
    scheduler : str or None
        Of workers that make images and errors; times are measured here. None: all is.
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
    with claimed_folder(outdir), ExitStack() as last:
        device = create_context(backend)
        last.callback(device.release)
        with stage_progress(quiet=quiet) as progress, Renderer(scene, settings, device=device) as r:
            base = dataclasses.replace(r.settings, antialias=1, estimator=None, max_error=None)
            machine = describe_machine(device, r.timer_kind, command)
            own = BenchRenderer(r)
            run = BenchRun(own, base, points, plan, quick, outdir, progress, camera, scheduler)
            run.leave_out_needless()
            try:
                bench = run.measure(scene_source, machine)
            except KeyboardInterrupt:
                if not holds_bench(outdir):
                    raise
                raise KeyboardInterrupt(
                    f"interrupted; {outdir} keeps what was measured, and the same command goes on"
                ) from None
            progress.say("writing tables, plots and report ...")
            report.write_report(bench, outdir)
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
    scheduler: str | None = None
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
        state = self._state()
        self._start_over_unless_same(state)
        mask = self._mask()
        with self._renderers() as renderer:
            references, judged = self._judged(renderer, state, mask)
        by_panel = references.by_panel
        rows = time_points(
            self.renderer,
            self.points,
            self.base,
            self.plan.rounds,
            self.plan.frames,
            self.outdir / ROUNDS,
            self.progress.steps,
        )
        table = tabulate(rows, self.points, self.plan.rounds, clock)
        results = analysis.analyse(self.points, table, judged)
        recommendation = analysis.recommend(results)
        chosen = report.chosen_results(results, recommendation)
        if "hdr" in self.plan.flips:
            results = report.with_hdr_flip(
                self.renderer, self.base, results, chosen, by_panel, mask, self.progress.steps
            )
            recommendation = analysis.recommend(results)
        radius_px = (self.base.radius or 0.0) * unit_px(self.renderer, self.base, mask)
        series = scaling.measure_scaling(
            self.renderer,
            self.base,
            radius_px,
            self.quick,
            clock,
            self.progress.steps,
        )
        bench = Bench(
            scene=source,
            title=self.renderer.scene.title or source,
            scene_settings=self.renderer.scene.render,
            camera=self.camera,
            loading=self.renderer.scene.loading,
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
            series=series,
            pictures=report.take_pictures(
                self.renderer, self.base, chosen, by_panel, mask, self.progress.steps
            ),
            notes=tuple(self.notes),
        )
        return dataclasses.replace(bench, splits=self._splits(report.split_results(bench), clock))

    @contextmanager
    def _renderers(self) -> Iterator[BenchRenderer]:
        """Yield who makes images and errors: this process, or workers, which are then noted."""
        with spread(self.renderer, self.scheduler) as (renderer, sentence):
            self.notes += [sentence] if sentence else []
            yield renderer

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

    def _state(self) -> dict[str, Any]:
        """Return what identifies this bench: a folder of another one is not continued."""
        parts = (scene_fingerprint(self.renderer.scene), self.base, self.points, self.plan)
        return {
            "bench": fingerprint(ERROR_FORMAT, parts, self.renderer.device_name, __version__),
            "shaders": shader_fingerprint(("",)),
        }

    def _start_over_unless_same(self, state: Mapping[str, Any]) -> None:
        """Continue the bench of the folder if it is this one; else forget its times.

        Its errors need not be removed: each says what it was measured for.
        """
        path = self.outdir / MARKER
        found = read_json(path)
        if found == state:
            self.progress.say(f"continuing the bench in {self.outdir}")
            return
        if found:
            self.progress.say(f"{self.outdir} holds another bench; measuring anew")
        (self.outdir / ROUNDS).unlink(missing_ok=True)
        replace_json(path, state)

    def _mask(self) -> Mask:
        mask = judged_pixels(self.renderer, self.base)
        if not mask.any():
            raise BenchError("the camera sees no surface: there is nothing to measure")
        return mask

    def _judged(
        self, renderer: BenchRenderer, state: Mapping[str, Any], mask: Mask
    ) -> tuple[ReferenceSet, dict[str, dict[str, Judged]]]:
        """Return what points are held to, and every point's errors."""
        request = ReferenceRequest(
            renderer,
            self.base,
            mask,
            sorted({point.kind for point in self.points}),
            self.plan.seeds,
            self.plan.batch_spp,
            self.plan.reference_seconds,
        )
        references = make_references(request, self.progress)
        judged = self._errors(renderer, state, references, mask)
        smallest = smallest_errors(judged)
        if not self.quick and not good_enough(references.by_panel, smallest, mask):
            # A setting came closer to a reference than the converged march did.
            request = dataclasses.replace(request, smallest=smallest)
            references = make_references(request, self.progress)
            judged = self._errors(renderer, state, references, mask)
        return references, judged

    def _errors(
        self,
        renderer: BenchRenderer,
        state: Mapping[str, Any],
        references: ReferenceSet,
        mask: Mask,
    ) -> dict[str, dict[str, Judged]]:
        """Return the errors of every point against every reference it can be held to."""
        counts = {name: reference.spp for name, reference in references.by_panel.items()}
        store = ErrorStore(self.outdir / ERRORS, fingerprint(dict(state), counts))
        flips = tuple(flip for flip in self.plan.flips if flip == "ldr")
        judging = Judging(self.base, references, mask, self.plan.seeds, flips)
        return judging.of_all(renderer, self.points, store, self.progress.steps)

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
