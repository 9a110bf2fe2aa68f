"""The tables of a report: fronts, and every setting with all its numbers."""

from __future__ import annotations

import math
from html import escape

from ssdo_gl.bench.analysis import Result, front_of, percent, sureness
from ssdo_gl.bench.bench_data import Bench
from ssdo_gl.bench.measure import ErrorPanel, error_panels
from ssdo_gl.bench.report.cells import (
    folded_command,
    interval_text,
    number,
    scrolling,
    sortable,
    table,
)
from ssdo_gl.bench.report.figures import error_text

# Of the first panel that judges a point.
_SCALARS = {
    "noise": "noise", "own bias": "own_bias", "systematic": "systematic", "relMSE": "rel_mse",
    "SSIM": "ssim", "FLIP": "flip_ldr", "HDR-FLIP": "flip_hdr",
}  # fmt: skip


def part_text(error: float) -> str:
    """Return the error of a part; what the reference's own variance explains is not none."""
    return percent(error) if error > 0.0 else "within noise"


def front_table(bench: Bench, panel: ErrorPanel) -> str:
    """Return a panel's front, numbered as in its chart; empty if it has none."""
    front = front_of(bench.results, panel.name)
    if not front:
        return ""

    def text(value: float) -> str:
        return "" if math.isnan(value) else error_text(panel, value)

    # Not of what the scene does not have.
    judged = [result.verdicts[panel.name] for result in front]
    parts = [p for p in panel.parts if any(v.scalars.parts.get(p, 0.0) > 0.0 for v in judged)]
    rows = []
    for place, (result, verdict) in enumerate(zip(front, judged, strict=True), 1):
        scalars, error = verdict.scalars, verdict.error
        rows.append(
            [
                f"{place}. {escape(result.point.label)}",
                interval_text(result.timing.ms),
                f"{text(error.value)} [{text(error.low)}, {text(error.high)}]",
                *(part_text(scalars.parts[part]) for part in parts),
                *map(text, (scalars.noise, scalars.own_bias, scalars.systematic)),
                sureness(verdict.confidence),
                folded_command(bench.command(result.point)),
            ]
        )
    alone = (f"{escape(part)} alone" for part in parts)
    head = (
        "setting", "ms [95 %]", "error [95 %]", *alone, "noise", "own bias", "systematic", "sure",
        "command",
    )  # fmt: skip
    return f"<h3>{escape(panel.title)}</h3>{table(head, rows, panel.title)}"


def points_table(bench: Bench) -> str:
    """Return every setting with all its numbers; the page's script sorts it."""
    names = _columns(bench, bench.results[0]) if bench.results else ()
    head = "".join(
        f'<th scope="col"><button type="button">{escape(name)}</button></th>'
        for name in ("setting", *names, "failed pixels")
    )
    body = "".join(_point_row(bench, result) for result in bench.results)
    content = (
        f'<table id="points"><thead><tr>{head}<th scope="col">command</th></tr></thead>'
        f"<tbody>{body}</tbody></table>"
    )
    return scrolling(content, "Every setting")


def _point_row(bench: Bench, result: Result) -> str:
    verdicts = result.verdicts.values()
    failures = next((verdict.scalars.failures for verdict in verdicts), 0)
    cells = [f"<td>{escape(result.point.label)}</td>"]
    values = _columns(bench, result).values()
    cells += [f'<td data-value="{sortable(v)}">{number(v)}</td>' for v in values]
    failed = ' class="failed"' if failures else ""
    cells.append(f'<td data-value="{failures}"{failed}>{failures}</td>')
    cells.append(f"<td>{folded_command(bench.command(result.point))}</td>")
    front = ' class="front"' if any(verdict.on_front for verdict in verdicts) else ""
    return f"<tr{front}>{''.join(cells)}</tr>"


def _columns(bench: Bench, result: Result) -> dict[str, float]:
    """Return the numbers of one point by column; the same columns for every point."""
    timing, verdicts = result.timing, result.verdicts
    shown = [p for p in error_panels() if p.name in bench.references]
    main = next((verdicts[p.name] for p in shown if p.name in verdicts), None)
    columns = {
        "ms": timing.ms.value,
        "wall ms": timing.frame_ms.value,
        "processor ms": timing.process_ms.value,
        "first frame ms": timing.setup_ms,
    }
    for panel in shown:
        verdict = verdicts.get(panel.name)
        columns[f"{panel.name} error"] = verdict.error.value if verdict else math.nan
        for part in panel.parts:
            columns[part] = verdict.scalars.parts.get(part, math.nan) if verdict else math.nan
    for name, field in _SCALARS.items():
        columns[name] = float(getattr(main.scalars, field)) if main else math.nan
    columns["bias"] = main.bias.value if main else math.nan
    return columns
