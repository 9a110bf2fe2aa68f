"""The bench as one HTML file that needs nothing else: no network, no other file."""

from __future__ import annotations

import base64
import html
import json
import math
from collections.abc import Iterable, Sequence
from importlib.resources import files
from string import Template
from typing import Any

from ssdo_gl.bench.analysis import Result, front_of, percent
from ssdo_gl.bench.bench_data import Bench
from ssdo_gl.bench.bootstrap import Interval
from ssdo_gl.bench.clock import CLOCK_NAMES
from ssdo_gl.bench.panels import ErrorPanel, error_panels
from ssdo_gl.bench.report import plots
from ssdo_gl.bench.report.sentences import (
    facts,
    machine_rows,
    method_paragraphs,
    reference_sentence,
)


def data_uri(data: bytes, kind: str) -> str:
    """Return bytes as a ``data:`` URI of a media type."""
    return f"data:{kind};base64,{base64.b64encode(data).decode('ascii')}"


def report_html(bench: Bench) -> str:
    """Return the report of a bench as one HTML document.

    Raises
    ------
    MissingLibraryError
        Without matplotlib.
    """
    template = files("ssdo_gl.bench.report").joinpath("report.html").read_text(encoding="utf-8")
    shown = [r for r in split_results(bench) if r.point.key in bench.splits]
    return Template(template).substitute(
        title=html.escape(f"{bench.title}: what accuracy costs"),
        subtitle=html.escape(
            f"{bench.scene}, {bench.base.size[0]}x{bench.base.size[1]}, {bench.machine['renderer']}"
            f" ({bench.machine['date']})"
        ),
        notes="".join(f'<p class="note">{html.escape(note)}</p>' for note in bench.notes),
        recommendation=_recommendation(bench),
        facts="".join(
            f"<li><b>{html.escape(name)}</b>{html.escape(value)}</li>"
            for name, value in facts(bench)
        ),
        pareto=_plot(plots.pareto_figure(bench)),
        compare=_compare(bench),
        fronts="".join(_front_table(bench, panel) for panel in error_panels()),
        references=_references(bench),
        samples=_plot(plots.samples_figure(bench)),
        scaling=_figure_or_note(
            plots.scaling_figure(bench) if bench.series else None,
            "Log-log, with least-squares exponents and their standard errors.",
            "Cost scaling was not measured in this run.",
        ),
        split=_figure_or_note(
            plots.split_figure(bench, shown) if shown else None,
            f"By the clock of the table ({CLOCK_NAMES[bench.clock]}); each pass waited for before "
            "the next starts, so sums exceed the frame times a little.",
            "Pass times were not measured in this run.",
        ),
        points_head=_points_head(bench),
        points_body="".join(_point_row(bench, result) for result in bench.results),
        method="".join(f"<p>{html.escape(text)}</p>" for text in method_paragraphs(bench)),
        machine=_table(("", ""), [[html.escape(c) for c in row] for row in machine_rows(bench)]),
        data=_embedded(_data(bench)),
    )


def split_results(bench: Bench) -> list[Result]:
    """Return the results whose pass times are worth showing: members of the fronts.

    Rays are left out: their one long pass would shrink all other bars to nothing.
    """
    chosen: dict[str, Result] = {}
    for panel in error_panels():
        for result in front_of(bench.results, panel.name):
            if not result.point.method.startswith("reference"):
                chosen.setdefault(result.point.key, result)
    return list(chosen.values())


def _plot(figure: Any) -> str:
    return data_uri(plots.as_bytes(figure, "svg"), "image/svg+xml")


def _figure_or_note(figure: Any, caption: str, otherwise: str) -> str:
    if figure is None:
        return f'<p class="note">{html.escape(otherwise)}</p>'
    return (
        f'<figure><img class="plot" alt="" src="{_plot(figure)}">'
        f"<figcaption>{html.escape(caption)}</figcaption></figure>"
    )


def _recommendation(bench: Bench) -> str:
    text = html.escape(bench.recommendation.sentence)
    result = bench.recommendation.result
    if result is None:
        return text
    return f"{text}<br><code>{html.escape(bench.command(result.point))}</code>"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table; cells are HTML already."""
    top = "".join(f"<th>{cell}</th>" for cell in head)
    body = "".join("<tr>" + "".join(f"<td>{c}</td>" for c in row) + "</tr>" for row in rows)
    return (
        f'<div class="scroll"><table><thead><tr>{top}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )


def number(value: float, digits: int = 3) -> str:
    """Return a number as tables show it; nothing for NaN."""
    if math.isnan(value):
        return ""
    return "inf" if math.isinf(value) else f"{value:.{digits}g}"


def interval_text(interval: Interval) -> str:
    """Return an estimate and its interval."""
    return f"{number(interval.value)} [{number(interval.low)}, {number(interval.high)}]"


def _front_table(bench: Bench, panel: ErrorPanel) -> str:
    front = front_of(bench.results, panel.name)
    if not front:
        return ""
    rows = []
    for result in front:
        verdict = result.verdicts[panel.name]
        rows.append(
            [
                html.escape(result.point.label),
                interval_text(result.timing.ms),
                interval_text(verdict.error),
                number(verdict.scalars.noise),
                number(verdict.scalars.own_bias),
                number(verdict.scalars.systematic),
                f"{verdict.confidence:.0%}",
            ]
        )
    head = ("setting", "ms [95 %]", "error [95 %]", "noise", "own bias", "systematic", "sure")
    return f"<h3>{html.escape(panel.title)}</h3>{_table(head, rows)}"


def _references(bench: Bench) -> str:
    items = [
        reference_sentence(panel, bench.references.get(panel.name)) for panel in error_panels()
    ]
    return "<ul>" + "".join(f"<li>{html.escape(item)}</li>" for item in items if item) + "</ul>"


def _compare(bench: Bench) -> str:
    if not bench.pictures:
        return '<p class="note">No pictures were kept in this run.</p>'

    def options(selected: int) -> str:
        return "".join(
            f'<option value="{i}"{" selected" if i == selected else ""}>'
            f"{html.escape(picture.name)}</option>"
            for i, picture in enumerate(bench.pictures)
        )

    reference = next((i for i, p in enumerate(bench.pictures) if p.is_reference), 0)
    other = next(
        (
            i
            for i, p in enumerate(bench.pictures)
            if not p.is_reference and p.group == bench.pictures[reference].group
        ),
        0,
    )
    first, second = bench.pictures[other], bench.pictures[reference]
    over, under = data_uri(first.png, "image/png"), data_uri(second.png, "image/png")
    return (
        '<div class="controls">'
        f'<label>left <select id="left">{options(other)}</select></label>'
        f'<label>right <select id="right">{options(reference)}</select></label>'
        '<label><input type="checkbox" id="flip"> FLIP map of the left one</label></div>'
        '<div class="compare" id="compare">'
        f'<img id="image-under" alt="right picture" src="{under}">'
        f'<div class="over" id="over" style="clip-path: inset(0 50% 0 0)">'
        f'<img id="image-over" alt="left picture" src="{over}"></div>'
        '<div class="edge" id="edge" style="left: 50%"></div>'
        f'<span class="name-left" id="name-left">{html.escape(first.name)}</span>'
        f'<span class="name-right" id="name-right">{html.escape(second.name)}</span></div>'
        '<input type="range" id="edge-slider" min="0" max="1000" value="500" '
        'aria-label="where the two pictures meet">'
        f'<p class="note" id="caption">{html.escape(first.caption)}</p>'
        '<p class="note">FLIP maps: black is no visible difference, bright is a large one.</p>'
    )


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


# Of the first panel that judges a point.
_SCALARS = {
    "noise": "noise", "own bias": "own_bias", "systematic": "systematic", "relMSE": "rel_mse",
    "SSIM": "ssim", "FLIP": "flip_ldr", "HDR-FLIP": "flip_hdr",
}  # fmt: skip


def _points_head(bench: Bench) -> str:
    numbers = _columns(bench, bench.results[0]) if bench.results else ()
    names = ("setting", *numbers, "failed pixels", "command")
    cells = "".join(f'<th><button type="button">{name}</button></th>' for name in names)
    return f"<tr>{cells}</tr>"


def _point_row(bench: Bench, result: Result) -> str:
    verdicts = result.verdicts.values()
    failures = next((verdict.scalars.failures for verdict in verdicts), 0)
    cells = [f"<td>{html.escape(result.point.label)}</td>"]
    values = _columns(bench, result).values()
    cells += [f'<td data-value="{_sortable(v)}">{number(v)}</td>' for v in values]
    failed = ' class="failed"' if failures else ""
    cells.append(f'<td data-value="{failures}"{failed}>{failures}</td>')
    cells.append(f'<td class="left"><code>{html.escape(bench.command(result.point))}</code></td>')
    front = ' class="front"' if any(verdict.on_front for verdict in verdicts) else ""
    return f"<tr{front}>{''.join(cells)}</tr>"


def _sortable(value: float) -> str:
    """Return a number as the page's script reads it; empty for NaN."""
    if math.isnan(value):
        return ""
    # JavaScript reads what overflows as infinity.
    return "1e999" if math.isinf(value) else f"{value:.6g}"


def _data(bench: Bench) -> dict[str, Any]:
    """Return what the script of the page draws."""
    clock = CLOCK_NAMES[bench.clock]
    panels = []
    for panel in error_panels():
        points = [_dot(r, panel) for r in bench.results if panel.name in r.verdicts]
        if points:
            reference = bench.references.get(panel.name)
            floor = reference.floor if reference and math.isfinite(reference.floor) else 0.0
            panels.append(
                {"title": panel.title, "unit": panel.error_label, "points": points, "floor": floor}
            )
    pictures = [
        {
            "name": picture.name,
            "group": picture.group,
            "reference": picture.is_reference,
            "caption": picture.caption,
            "png": data_uri(picture.png, "image/png"),
            "flip": data_uri(picture.flip_png, "image/png") if picture.flip_png else None,
        }
        for picture in bench.pictures
    ]
    return {"panels": panels, "pictures": pictures, "clock": f"frame time, ms ({clock})"}


def _dot(result: Result, panel: ErrorPanel) -> dict[str, Any]:
    verdict, timing = result.verdicts[panel.name], result.timing
    finite = math.isfinite(verdict.error.value)
    error = percent(verdict.error.value) if panel.relative else number(verdict.error.value)
    return {
        "label": result.point.label,
        "family": result.point.family,
        "x": timing.ms.value,
        "x_low": timing.ms.low,
        "x_high": timing.ms.high,
        "y": verdict.error.value if finite else 0.0,
        "low": verdict.error.low if finite else 0.0,
        "high": verdict.error.high if math.isfinite(verdict.error.high) else 0.0,
        "front": verdict.on_front,
        "tip": (
            f"{result.point.label}\n{timing.ms.value:.3g} ms, error {error}\n"
            f"noise {number(verdict.scalars.noise)}, systematic "
            f"{number(verdict.scalars.systematic)}\n"
            f"on the front: {verdict.confidence:.0%} sure"
        ),
    }


def _embedded(content: Any) -> str:
    """Return JSON that may stand inside a script element."""
    text = json.dumps(content, allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")
