"""The ladder of presets, in minutes: times and errors of its rungs and of all about them.

``make bench-presets`` runs ``python -m benchmarks.rungs OUTDIR [SCENE ...]``. It measures what
``make bench`` does of the published method and of the march, with fewer rounds and patterns and
against the near field alone. OUTDIR receives a table of each scene; printed are the ladder, and
for each scene the published method beside the march at equal time and at equal error, and time
and error of each setting over those of the published method.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.common import answering, check_scenes, command, size_of
from benchmarks.equal import MARCH, PAPER, compare, comparison_lines, curve_of
from benchmarks.preset_ladder import BASELINE, derive, ladder_text
from ssdo_gl.bench.measure import (
    BenchRenderer,
    Goal,
    Point,
    ReferenceCache,
    describe_machine,
    judge,
    judged_pixels,
    obtain,
    panel_named,
    read_grid,
    render_seeds,
    tabulate,
    time_points,
    trusted_clock,
)
from ssdo_gl.bench.measure.machine import CLOCK_NAMES
from ssdo_gl.bench.statistics import rmse_of
from ssdo_gl.bench.storage import csv_bytes, replace_file
from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.options.resolve import settings_for
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene

SCENES = ("cornell_meso", "courtyard", "stairs")
SIZE = (320, 180)
GRID = Path(__file__).with_name("rungs.toml")
ROUNDS, FRAMES, SEEDS = 7, 2, 3
REFERENCE_SPP, REFERENCE_GOAL, REFERENCE_SECONDS = 64, 0.01, 600.0
Row = dict[str, str]


def measure(
    name: str, device: Device, folder: Path, size: tuple[int, int]
) -> tuple[list[Row], dict[str, Any]]:
    """Return a row for each point of the grid, as ``points.csv`` has them, and the machine."""
    points = read_grid(GRID)
    scene = load_scene(name)
    with Renderer(scene, settings_for(scene.render, {"size": size}), device=device) as renderer:
        own = BenchRenderer(renderer)
        base = dataclasses.replace(renderer.settings, antialias=1, max_error=None)
        machine = describe_machine(device, renderer.timer_kind, "")
        machine["clock"] = trusted_clock(machine)
        errors = errors_of(own, points, base)
        visits = folder / f"{Path(name).stem}-rounds.csv"
        visits.unlink(missing_ok=True)
        rows = time_points(own, points, base, ROUNDS, FRAMES, visits)
    times = tabulate(rows, points, ROUNDS, machine["clock"]).ms
    table = [
        {
            **{field: str(value) for field, value in dataclasses.asdict(point).items()},
            "key": point.key,
            "label": point.label,
            "ms": str(sorted(ms)[len(ms) // 2]),
            "near_error": str(error),
        }
        for point, ms, error in zip(points, times, errors, strict=True)
    ]
    return table, machine


def errors_of(renderer: BenchRenderer, points: Sequence[Point], base: Any) -> list[float]:
    """Return the relative RMSE of each point against the ray-traced near field."""
    panel = dataclasses.replace(panel_named("near"), parts=())
    mask = judged_pixels(renderer, base)
    settings = dataclasses.replace(base, method=panel.method, spp=REFERENCE_SPP)
    goal = Goal(panel.aov, REFERENCE_GOAL, True, REFERENCE_SECONDS)
    reference = obtain(renderer, settings, panel.aovs, goal, mask, ReferenceCache())
    errors = []
    for point in points:
        images = render_seeds(renderer, point, base, SEEDS, panel.aovs)
        blocks = judge(panel, images, reference, mask, 0.0).blocks
        errors.append(rmse_of(blocks, relative=True))
    return errors


def over_published(rows: Sequence[Row]) -> list[str]:
    """Return the lines of a table: time and error over those of the ladder's unit."""
    unit = next(row for row in rows if row["key"] == BASELINE)
    lines = ["| setting | time | error |", "|---|--:|--:|"]
    for row in rows:
        time, error = (float(row[name]) / float(unit[name]) for name in ("ms", "near_error"))
        lines.append(f"| {row['label']} | {time:.2f} | {error:.2f} |")
    return lines


@answering
def main(argv: Sequence[str] | None = None) -> int:
    """Measure the scenes named on the command line and print what follows."""
    parser = command("rungs", __doc__)
    parser.add_argument("outdir", type=Path, metavar="OUTDIR")
    parser.add_argument("scenes", nargs="*", default=SCENES, metavar="SCENE")
    parser.add_argument("--size", type=size_of, default=SIZE, metavar="WxH")
    options = parser.parse_args(argv)
    check_scenes(options.scenes)
    size = options.size
    options.outdir.mkdir(parents=True, exist_ok=True)
    tables: dict[str, list[Row]] = {}
    machine: dict[str, Any] = {}
    device = create_context("auto")
    try:
        for name in options.scenes:
            rows, machine = measure(name, device, options.outdir, size)
            tables[name] = rows
            replace_file(options.outdir / f"{Path(name).stem}.csv", csv_bytes(rows))
            paper, march = curve_of(rows, "paper's SSDO", PAPER), curve_of(rows, "march", MARCH)
            lines = [*comparison_lines(compare(paper, march)), "", *over_published(rows)]
            print(f"\n{name}\n\n" + "\n".join(lines), flush=True)
    finally:
        device.release()
    rungs, presets = derive(list(tables.values()))
    source = {
        "benches": [f"{name} {size[0]}x{size[1]}" for name in tables],
        "renderer": machine["renderer"],
        "clock": CLOCK_NAMES[machine["clock"]],
        "version": machine["ssdo_gl"],
        "date": str(machine["date"])[:10],
    }
    print("\n" + ladder_text(rungs, presets, source))
    return 0


if __name__ == "__main__":
    sys.exit(main())
