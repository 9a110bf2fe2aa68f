"""The table of the first SSDO report, measured here, with its arithmetic put right.

``make bench`` runs ``python -m benchmarks.report_table``, which prints it.

The report (C. Javault, INF584 course project, 2020) timed a CPU renderer at 150x150 and
"normalised" its 1024-sample SSDO to 16 samples by scaling all of its 5820 ms, the fixed
39 ms of its z-buffer included, and did not add those back: 91 ms. Kept apart, the fixed
cost gives (5820 - 39) * 16 / 1024 + 39 = 129 ms. Here every row is timed at its own sample
count and at 16, and what does not depend on samples is measured, not scaled.
"""

from __future__ import annotations

import dataclasses
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

from benchmarks.common import answering, command
from ssdo_gl.bench.measure.bench_renderer import BenchRenderer
from ssdo_gl.bench.measure.clock import CLOCK_NAMES, CLOCKS, trusted_clock
from ssdo_gl.bench.measure.machine import describe_machine
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings

SIZE = (150, 150)
NORMAL_SAMPLES = 16
# Of the printed table, columns.
WIDTH = 160
# References are slow and steady, the rest fast and noisy.
FRAMES, REFERENCE_FRAMES = 9, 2


@dataclass(frozen=True)
class ReportRow:
    """One row: a method, its samples, and what the report says it took.

    Attributes
    ----------
    count_field : str or None
        The setting that counts samples; None if there is nothing to count.
    report_ms : float
        NaN where the report's number for this row is not known to us.
    report_normal_ms : float
        The report's number for 16 samples, as printed.
    """

    name: str
    settings: dict[str, Any]
    wanted: str
    count_field: str | None
    count: int
    report_ms: float = math.nan
    report_normal_ms: float = math.nan


ROWS = (
    ReportRow("visible surfaces (z-buffer)", {"method": "direct"}, "depth", None, 1, 39.0),
    ReportRow(
        "direct light, 256 shadow rays",
        {"method": "direct", "shadows": "traced"},
        "beauty",
        "shadow_rays",
        256,
    ),
    ReportRow("direct light, shadow maps", {"method": "direct"}, "beauty", None, 1),
    ReportRow("full transport, 16 paths", {"method": "reference-gi"}, "beauty", "spp", 16),
    ReportRow("full transport, 256 paths", {"method": "reference-gi"}, "beauty", "spp", 256),
    ReportRow("ray-traced AO, 256 rays", {"method": "reference-ao"}, "visibility", "spp", 256),
    ReportRow(
        "ray-traced AO, 16 rays; direct light, 1 ray",
        {"method": "reference-ao", "combine": "report", "shadow_rays": 1},
        "beauty",
        "spp",
        16,
        470.0,
    ),
    ReportRow(
        "SSAO in image space, 16 reads",
        {"method": "ssao", "estimator": "zbuffer"},
        "visibility",
        "samples",
        16,
        55.0,
        55.0,
    ),
    ReportRow(
        "SSAO, hemisphere, 64 reads",
        {"method": "ssao", "estimator": "hemisphere"},
        "visibility",
        "samples",
        64,
    ),
    ReportRow(
        "SSDO and bounce, paper's, 1024 reads",
        {"method": "bounce", "estimator": "rgs09"},
        "beauty",
        "samples",
        1024,
        5820.0,
        91.0,
    ),
    ReportRow(
        "SSDO and bounce, march, 1024 reads",
        {"method": "bounce", "estimator": "march"},
        "beauty",
        "samples",
        1024,
    ),
)


@dataclass(frozen=True)
class MeasuredRow:
    """One measured row; milliseconds.

    Attributes
    ----------
    ms : float
        At the row's own sample count.
    normal_ms : float
        Measured at 16 samples.
    fixed_ms, per_sample_ms : float
        From both: ms = fixed + per_sample * count.
    """

    method: ReportRow
    ms: float
    normal_ms: float
    fixed_ms: float
    per_sample_ms: float


def report_normalised(ms: float, fixed_ms: float, count: int) -> float:
    """Return the time at 16 samples when only what depends on them is scaled."""
    return (ms - fixed_ms) * NORMAL_SAMPLES / count + fixed_ms


def measure(
    bench_renderer: BenchRenderer,
    base: Settings,
    methods: Sequence[ReportRow] = ROWS,
    clock: str = "wall",
) -> list[MeasuredRow]:
    """Time every row at its own sample count and at 16, by one of `CLOCKS`."""
    rows = []
    for method in methods:
        plain = {"estimator": None, "filter": "none"}
        settings = dataclasses.replace(base, **{**plain, **method.settings})
        frames = REFERENCE_FRAMES if settings.is_reference else FRAMES

        def at(
            count: int,
            method: ReportRow = method,
            settings: Settings = settings,
            frames: int = frames,
        ) -> float:
            counted: dict[str, Any] = {method.count_field: count} if method.count_field else {}
            chosen = dataclasses.replace(settings, **counted).checked()
            times = bench_renderer.timed(chosen, (method.wanted,), frames)
            return float(getattr(times, CLOCKS[clock]))

        own = at(method.count)
        same = method.count_field is None or method.count == NORMAL_SAMPLES
        normal = own if same else at(NORMAL_SAMPLES)
        if same:
            slope, fixed = math.nan, math.nan
        else:
            slope = (own - normal) / (method.count - NORMAL_SAMPLES)
            fixed = normal - slope * NORMAL_SAMPLES
        rows.append(MeasuredRow(method, own, normal, fixed, slope))
    return rows


def as_table(rows: Sequence[MeasuredRow], title: str) -> Table:
    """Return the rows as a table, the report's numbers beside them."""
    table = Table(title=title, title_justify="left", box=box.MARKDOWN)
    table.add_column("method", no_wrap=True)
    columns = "report ms,ours ms,report at 16,put right,ours at 16,fixed ms,us a sample"
    for column in columns.split(","):
        table.add_column(column, justify="right")
    zbuffer = next((m.report_ms for m in ROWS if m.count_field is None), math.nan)
    for row in rows:
        method = row.method
        right = math.nan
        if method.count != NORMAL_SAMPLES and not math.isnan(method.report_ms):
            right = report_normalised(method.report_ms, zbuffer, method.count)
        table.add_row(
            method.name,
            _cell(method.report_ms, 0),
            _cell(row.ms, 1),
            _cell(method.report_normal_ms, 0),
            _cell(right, 0) if method.count_field else "",
            _cell(row.normal_ms, 1),
            _cell(row.fixed_ms, 1),
            _cell(1e3 * row.per_sample_ms, 1),
        )
    return table


def _cell(value: float, digits: int) -> str:
    return "" if math.isnan(value) else f"{value:.{digits}f}"


def measured_table(renderer: Renderer) -> Table:
    """Return the table, measured now on the renderer's scene at its size."""
    machine = describe_machine(renderer.device, renderer.timer_kind, "")
    clock = trusted_clock(machine)
    rows = measure(BenchRenderer(renderer), renderer.settings, clock=clock)
    width, height = renderer.settings.size
    title = (
        f"{renderer.scene.title}, {width}x{height}; {machine['renderer']}, "
        f"{machine['cores']} cores of {machine['processor']}; {CLOCK_NAMES[clock]}"
    )
    return as_table(rows, title)


@answering
def main(argv: Sequence[str] | None = None) -> int:
    """Measure the table on ``cornell_meso`` and print it."""
    command("report_table", __doc__).parse_args(argv)
    with Renderer(load_scene("cornell_meso"), Settings(size=SIZE)) as renderer:
        table = measured_table(renderer)
    Console(width=WIDTH).print(table)
    return 0


if __name__ == "__main__":
    sys.exit(main())
