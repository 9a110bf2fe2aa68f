"""Checks what `tune` promises: budgets by 50 frames, errors by fresh seeds and another view.

``make bench-promises`` runs ``python -m benchmarks.promises [SCENE ...]``, which prints a Markdown
table for each scene. Errors are those from all light, as ``--max-error`` bounds them by default.
Budgets are of the wall clock, so ask for them with ``--only time`` where little else runs.
"""

from __future__ import annotations

import dataclasses
import statistics
import sys
from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.common import answering, check_scenes, command
from ssdo_gl.bench.analysis import percent
from ssdo_gl.bench.measure.bench_renderer import BenchRenderer
from ssdo_gl.bench.measure.errors import judge, judged_pixels
from ssdo_gl.bench.measure.panels import panel_named
from ssdo_gl.bench.measure.reference_cache import Goal, ReferenceCache, obtain
from ssdo_gl.bench.presets import read_ladder
from ssdo_gl.bench.statistics.bootstrap import draw, rmse_interval
from ssdo_gl.bench.tuning.error_bound import choose_for_error
from ssdo_gl.bench.tuning.tune import Choice, choose_for_budget
from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

SCENES = ("cornell_meso", "courtyard", "stairs")
SIZE = (320, 180)
FRAMES = 50
# Far from the seeds that the calibration took.
FRESH_SEED = 777
# The other view: the camera turned about its target.
TURN_DEGREES = 20.0
# Budgets and bounds lie between these parts of the ladder's range, so that there is
# something to choose.
PARTS = (0.2, 0.5, 0.8)
REFERENCE_SPP, REFERENCE_GOAL, REFERENCE_SECONDS = 64, 0.01, 60.0
# A budget counts as honoured if the median frame is not above it by more than this.
TOLERANCE = 0.15


@dataclass(frozen=True)
class Check:
    """One promise and what came of it."""

    promise: str
    choice: Choice
    found: str
    kept: bool


def between(low: float, high: float, part: float) -> float:
    """Return the geometric interpolation of two positive numbers."""
    return float(low ** (1.0 - part) * high**part)


def check_budgets(scene: Scene, device: Device) -> list[Check]:
    """Choose for three budgets and time 50 frames of each choice."""
    rungs = read_ladder().rungs
    with Renderer(scene, Settings(size=SIZE), device=device) as renderer:
        bench_renderer = BenchRenderer(renderer)
        base = renderer.settings
        ends = [
            bench_renderer.timed(rung.applied(base), ("beauty",), 9).frame_ms
            for rung in (rungs[0], rungs[-1])
        ]
    checks = []
    for part in PARTS:
        budget = between(ends[0], ends[1], part)
        choice = choose_for_budget(scene, Settings(size=SIZE), budget, device=device)
        with Renderer(scene, choice.settings, device=device) as renderer:
            median = statistics.median(renderer.render(("beauty",), frames=FRAMES).frame_ms)
        kept = median <= budget * (1.0 + TOLERANCE)
        found = f"{median:.1f} ms ({median / budget - 1.0:+.0%})"
        checks.append(Check(f"{budget:.1f} ms", choice, found, kept))
    return checks


def error_of(scene: Scene, settings: Settings, device: Device) -> tuple[float, float]:
    """Return the error of `settings` on `scene` from all light: (value, upper end)."""
    panel = dataclasses.replace(panel_named("gi"), parts=())
    with Renderer(scene, settings, device=device) as renderer:
        bench_renderer = BenchRenderer(renderer)
        base = renderer.settings
        mask = judged_pixels(bench_renderer, base)
        reference = obtain(
            bench_renderer,
            dataclasses.replace(base, method=panel.method, spp=REFERENCE_SPP),
            (panel.aov,),
            Goal(panel.aov, REFERENCE_GOAL, True, REFERENCE_SECONDS),
            mask,
            ReferenceCache(),
        )
        images = [
            bench_renderer.images(dataclasses.replace(settings, seed=FRESH_SEED + i), (panel.aov,))
            for i in range(2)
        ]
    blocks = judge(panel, images, reference, mask, 0.0).blocks
    interval = rmse_interval(blocks, draw(blocks.block_count, 2), relative=True)
    return interval.value, interval.high


def check_errors(scene: Scene, device: Device) -> list[Check]:
    """Choose for three error bounds; check with fresh seeds, here and from elsewhere."""
    rungs = read_ladder().rungs
    settings = Settings(size=SIZE)
    with Renderer(scene, settings, device=device) as renderer:
        base = renderer.settings
    worst = error_of(scene, rungs[0].applied(base), device)[1]
    best = error_of(scene, rungs[-1].applied(base), device)[1]
    checks = []
    for part in PARTS:
        # From above the worst to what the best just reaches.
        bound = between(1.2 * worst, 1.02 * best, part)
        choice = choose_for_error(scene, settings, bound, device=device)
        other = dataclasses.replace(scene, camera=scene.camera.orbit(TURN_DEGREES))
        here = error_of(scene, choice.settings, device)[0]
        there = error_of(other, choice.settings, device)[0]
        found = f"{percent(here)} here, {percent(there)} from elsewhere"
        checks.append(Check(percent(bound), choice, found, max(here, there) <= bound))
    return checks


def table(title: str, checks: Sequence[Check]) -> list[str]:
    """Return checks as Markdown."""
    lines = [f"### {title}", "", "| promised | chosen | found | kept |", "|---|---|---|---|"]
    for check in checks:
        chosen = check.choice.sentence.split(":")[0].removeprefix("chose ")
        kept = "yes" if check.kept else "no"
        lines.append(f"| {check.promise} | {chosen} | {check.found} | {kept} |")
    return [*lines, ""]


@answering
def main(argv: Sequence[str] | None = None) -> int:
    """Check the promises on the named scenes; 1 if one was broken."""
    parser = command("promises", __doc__)
    parser.add_argument("scenes", nargs="*", default=SCENES, metavar="SCENE")
    parser.add_argument("--only", choices=("time", "error"))
    options = parser.parse_args(argv)
    check_scenes(options.scenes)
    broken = 0
    device = create_context("auto")
    try:
        for name in options.scenes:
            scene = load_scene(name)
            for title, check in (("time", check_budgets), ("error", check_errors)):
                if options.only not in (None, title):
                    continue
                checks = check(scene, device)
                broken += sum(not item.kept for item in checks)
                print("\n".join(table(f"{name}: {title}", checks)), flush=True)
    finally:
        device.release()
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
