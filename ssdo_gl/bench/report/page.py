"""The bench as one HTML file that needs nothing else: no network, no other file."""

from __future__ import annotations

import json
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from string import Template
from typing import Any

from ssdo_gl.bench.analysis import Result, front_of
from ssdo_gl.bench.bench_data import Bench
from ssdo_gl.bench.measure import CLOCK_NAMES, error_panels
from ssdo_gl.bench.report import key
from ssdo_gl.bench.report.advice import (
    answer_data,
    answer_section,
    measured_panels,
    parts_section,
    presets_section,
    recommendations,
    usual_answers,
)
from ssdo_gl.bench.report.cells import table
from ssdo_gl.bench.report.charts import CHART_CSS, DARK, LIGHT, Figure
from ssdo_gl.bench.report.data_files import bench_json, points_csv
from ssdo_gl.bench.report.figures import front_chart, samples_charts, scaling_charts, split_chart
from ssdo_gl.bench.report.gallery import data_uri, gallery
from ssdo_gl.bench.report.sentences import (
    facts,
    machine_rows,
    method_paragraphs,
    reference_sentence,
)
from ssdo_gl.bench.report.tables import front_table, points_table
from ssdo_gl.bench.scaling import PARTS


def _source(name: str) -> str:
    return files("ssdo_gl.bench.report").joinpath(name).read_text(encoding="utf-8")


def report_html(bench: Bench) -> str:
    """Return the report of a bench as one HTML document."""
    shown = [r for r in split_results(bench) if r.point.key in bench.splits]
    machine = [[escape(cell) for cell in row] for row in machine_rows(bench)]
    return Template(_source("report.html")).substitute(
        title=escape(f"{bench.title}: what accuracy costs"),
        subtitle=escape(
            f"{bench.scene}, {bench.base.size[0]}x{bench.base.size[1]}, {bench.machine['renderer']}"
            f" ({bench.machine['date']})"
        ),
        style=_style(),
        notes="".join(f'<p class="note">{escape(note)}</p>' for note in bench.notes),
        answers=answer_section(bench),
        recommendations=recommendations(bench),
        answers_on_paper=_on_paper(bench),
        downloads=_downloads(bench),
        facts="".join(
            f"<li><b>{escape(name)}</b>{escape(value)}</li>" for name, value in facts(bench)
        ),
        parts=parts_section(bench),
        key=key.key_html(key.entries([result.point for result in bench.results])),
        fronts="".join(_chart(front_chart(bench, panel)) for panel in measured_panels(bench)),
        gallery=gallery(bench),
        front_tables="".join(front_table(bench, panel) for panel in error_panels()),
        references=_references(bench),
        samples=_charts(samples_charts(bench), "No unfiltered settings were measured in this run."),
        part_key=_part_key(bench),
        scaling=_charts(scaling_charts(bench), "Cost scaling was not measured in this run."),
        split=_split(bench, shown),
        points=points_table(bench),
        method="".join(f"<p>{escape(text)}</p>" for text in method_paragraphs(bench)),
        machine=table(("", ""), machine, "The machine"),
        data=_embedded(answer_data(bench)),
        script=_source("report.js"),
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


def _style() -> str:
    dark = f"{DARK}{key.css_colors(dark=True)}"
    return (
        f":root{{color-scheme:light dark;{LIGHT}{key.css_colors()}}}"
        f"@media screen and (prefers-color-scheme:dark){{:root{{{dark}}}}}"
        f"{key.css_classes()}{CHART_CSS}{_source('report.css')}"
    )


def _on_paper(bench: Bench) -> str:
    """Return what needs no script; a script folds it."""
    if not measured_panels(bench):
        return ""
    return (
        f'<details id="usual" open><summary>Answers to usual bounds</summary>'
        f"{usual_answers(bench)}</details>"
        f'<details id="presets" open><summary>Presets and budgets</summary>'
        f"{presets_section(bench)}</details>"
    )


def _downloads(bench: Bench) -> str:
    contents = (
        ("points.csv", points_csv(bench), "text/csv"),
        ("bench.json", bench_json(bench), "application/json"),
    )
    links = "".join(
        f'<a download="{name}" href="{data_uri(data, kind)}">{name}</a> '
        for name, data, kind in contents
    )
    return f'<p class="downloads">Download {links}</p>'


def _chart(figure: Figure) -> str:
    """Return a chart with what is said of it."""
    note = f'<p class="note">{escape(figure.note)}</p>' if figure.note else ""
    return f"<figure><figcaption>{escape(figure.title)}</figcaption>{figure.svg}{note}</figure>"


def _charts(charts: Sequence[Figure], otherwise: str) -> str:
    if not charts:
        return f'<p class="note">{escape(otherwise)}</p>'
    return f'<div class="charts">{"".join(map(_chart, charts))}</div>'


def _part_key(bench: Bench) -> str:
    curves = (name for series in bench.series for name in series.curves)
    passes = (PARTS.get(name, "rest") for split in bench.splits.values() for name, _ in split)
    return key.key_html(key.part_entries({*curves, *passes}))


def _split(bench: Bench, shown: Sequence[Result]) -> str:
    if not shown:
        return '<p class="note">Pass times were not measured in this run.</p>'
    chart = split_chart(bench, shown)
    return (
        f'<figure class="split">{chart.svg}<figcaption>By the clock of the table '
        f"({escape(CLOCK_NAMES[bench.clock])}); each pass waited for before the next starts, so "
        "sums exceed the frame times a little. Point at a part for its pass.</figcaption></figure>"
    )


def _references(bench: Bench) -> str:
    items = [
        reference_sentence(panel, bench.references.get(panel.name)) for panel in error_panels()
    ]
    return "<ul>" + "".join(f"<li>{escape(item)}</li>" for item in items if item) + "</ul>"


def _embedded(content: Any) -> str:
    """Return JSON that may stand inside a script element."""
    text = json.dumps(content, allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")
