"""The headline experiments, from finished benches and a few renderings of their own.

``make bench`` runs ``python -m benchmarks.experiments OUTDIR BENCH...``, which writes into OUTDIR

- ``report_table.txt``: the first SSDO report's table, measured here, put right;
- ``world_scale.png``: the bounce in other units of length, ``rgs09`` against ``march``;
- ``experiments.md``: those, and for every bench folder the paper's SSDO against the march
  at equal time and at equal error, how cost grows, and whether two benches of the same
  scene agree on the front.
"""

from __future__ import annotations

import dataclasses
import io
import itertools
import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from benchmarks import report_table, world_scale
from benchmarks.common import FinishedBench, answering, command, read_bench
from benchmarks.equal import Comparison, agreement, compare, curve_of
from ssdo_gl.bench.analysis import percent
from ssdo_gl.bench.measure.bench_renderer import BenchRenderer, opener
from ssdo_gl.bench.measure.errors import judged_pixels
from ssdo_gl.bench.measure.panels import panel_named
from ssdo_gl.bench.measure.reference_cache import Goal, ReferenceCache, obtain
from ssdo_gl.bench.report import as_bytes, check_libraries
from ssdo_gl.bench.statistics.fit import fit_power_law
from ssdo_gl.bench.storage import replace_file
from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings

PAPER = ("paper's ssdo, naive blur",)
MARCH = ("march, half resolution", "march, full resolution")
SCALE_SCENE, SCALE_SIZE = "cornell_meso", (320, 180)
# The bounce's reference, relative to its own mean; its errors there are tens of percent.
SCALE_GOAL, SCALE_SPP, SCALE_SECONDS = 0.03, 256, 120.0
# Runs contradict each other where both are this sure of the opposite.
AGREEMENT_CONFIDENCE = 0.95


def comparison_lines(found: Comparison) -> list[str]:
    """Return a Markdown table of one family against another."""
    other = found.second
    lines = [
        f"| {found.first} | ms | error | {other} in that time | {other} at that error, ms |",
        "|---|---|---|---|---|",
    ]
    for (label, ms, error, reached), (_, _, _, needed) in zip(
        found.equal_time, found.equal_error, strict=True
    ):
        cells = (label, f"{ms:.1f}", percent(error), _share(reached), _milliseconds(needed))
        lines.append("| " + " | ".join(cells) + " |")
    lines.append("")
    lines.append(
        f"At equal time the march has {_times(found.error_ratio)} the error; at equal error it "
        f"takes {_times(found.time_ratio)} the time (geometric means)."
    )
    return lines


def _share(value: float) -> str:
    return percent(value) if math.isfinite(value) else "nothing fits"


def _milliseconds(value: float) -> str:
    return f"{value:.1f}" if math.isfinite(value) else "never"


def _times(ratio: float) -> str:
    return "no comparable part of" if math.isnan(ratio) else f"{ratio:.2f} times"


def growth_lines(series: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return a Markdown table of fitted exponents: which cost grows with what."""
    parts = list(dict.fromkeys(part for item in series for part in item["curves"]))
    lines = [
        "| exponent of cost in | " + " | ".join(item["name"] for item in series) + " |",
        "|---|" + "---|" * len(series),
    ]
    for part in parts:
        cells = []
        for item in series:
            values = [math.nan if v is None else float(v) for v in item["curves"].get(part, [])]
            law = fit_power_law(item["x"][: len(values)], values)
            cells.append(str(law) if law else "")
        lines.append(f"| {part} | " + " | ".join(cells) + " |")
    return lines


def agreement_lines(first: FinishedBench, second: FinishedBench) -> list[str]:
    """Return where two benches of one scene contradict each other about the fronts."""
    lines = []
    for panel in ("near", "gi", "visibility"):
        column = f"{panel}_front_confidence"
        theirs = {row["key"]: row for row in second.rows if row[column]}
        shared = [row for row in first.rows if row[column] and row["key"] in theirs]
        if not shared:
            continue
        one = np.array([float(row[column]) for row in shared])
        two = np.array([float(theirs[row["key"]][column]) for row in shared])
        clash = [shared[i]["label"] for i in agreement(one, two, AGREEMENT_CONFIDENCE)]
        both = sum(
            row[f"{panel}_front"] == theirs[row["key"]][f"{panel}_front"] == "1" for row in shared
        )
        either = sum(
            "1" in (row[f"{panel}_front"], theirs[row["key"]][f"{panel}_front"]) for row in shared
        )
        verdict = f"contradictions: {', '.join(clash)}" if clash else "no contradiction"
        lines.append(
            f"- {panel}: {both} of {either} members in common, {verdict} at "
            f"{AGREEMENT_CONFIDENCE:.0%} confidence"
        )
    return lines


def run_world_scale(device: Device, cache: ReferenceCache) -> list[world_scale.ScaleCurve]:
    """Measure the bounce of the scale scene in other units of length."""
    scene = load_scene(SCALE_SCENE)
    panel = panel_named("near")
    with Renderer(scene, Settings(size=SCALE_SIZE), device=device) as renderer:
        bench_renderer = BenchRenderer(renderer)
        base = renderer.settings
        mask = judged_pixels(bench_renderer, base)
        reference = obtain(
            bench_renderer,
            dataclasses.replace(base, method=panel.method, spp=SCALE_SPP),
            panel.aovs,
            Goal("bounce", SCALE_GOAL, True, SCALE_SECONDS),
            mask,
            cache,
        )
    return world_scale.measure_world_scale(scene, base, reference, mask, opener(device))


def scale_lines(curves: Sequence[world_scale.ScaleCurve]) -> list[str]:
    """Return the curves of `measure_world_scale` as a Markdown table."""
    factors = curves[0].factors
    lines = [
        "| mean bounce / reference at scale | " + " | ".join(f"{f:g}" for f in factors) + " |",
        "|---|" + "---|" * len(factors),
    ]
    for curve in curves:
        lines.append(f"| {curve.name} | " + " | ".join(f"{v:.3g}" for v in curve.levels) + " |")
    return lines


def run_report_table(device: Device) -> str:
    """Return the report's table as text, measured now."""
    settings = Settings(size=report_table.SIZE)
    with Renderer(load_scene(SCALE_SCENE), settings, device=device) as renderer:
        table = report_table.measured_table(renderer)
    buffer = io.StringIO()
    Console(file=buffer, width=report_table.WIDTH).print(table)
    return buffer.getvalue()


def bench_sections(benches: Sequence[FinishedBench]) -> list[str]:
    """Return what the finished benches say, as Markdown."""
    lines: list[str] = []
    for bench in benches:
        lines += ["", f"## {bench.name}: paper's SSDO against the march", ""]
        paper = curve_of(bench.rows, "paper's SSDO", PAPER)
        march = curve_of(bench.rows, "the march", MARCH)
        lines += comparison_lines(compare(paper, march))
        lines += ["", f"## {bench.name}: how cost grows", "", *growth_lines(bench.meta["series"])]
    for first, second in itertools.combinations(benches, 2):
        if first.name == second.name:
            lines += ["", f"## {first.name}: do two runs agree?", ""]
            lines += agreement_lines(first, second)
    return lines


@answering
def main(argv: Sequence[str] | None = None) -> int:
    """Run the experiments and write what they found."""
    parser = command("experiments", __doc__)
    parser.add_argument("outdir", type=Path, metavar="OUTDIR")
    parser.add_argument("benches", nargs="*", type=Path, metavar="BENCH")
    options = parser.parse_args(argv)
    check_libraries()
    benches = [read_bench(folder) for folder in options.benches]
    outdir: Path = options.outdir
    outdir.mkdir(parents=True, exist_ok=True)
    device = create_context("auto")
    try:
        table = run_report_table(device)
        curves = run_world_scale(device, ReferenceCache())
    finally:
        device.release()
    figure = world_scale.scale_figure(curves)
    lines = ["# Experiments", "", "## The first report's table", "", table.strip()]
    lines += ["", f"## Units of length ({SCALE_SCENE})", "", *scale_lines(curves)]
    lines += bench_sections(benches)
    replace_file(outdir / "report_table.txt", table.encode())
    replace_file(outdir / "world_scale.png", as_bytes(figure, "png"))
    text = "\n".join(lines) + "\n"
    replace_file(outdir / "experiments.md", text.encode())
    print(text, end="")
    return 0


if __name__ == "__main__":
    sys.exit(main())
