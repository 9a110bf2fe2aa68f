"""What a report says first: which setting to take, and what its error hides."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

from ssdo_gl.bench.analysis import Result, front_of, percent, recommend, sureness
from ssdo_gl.bench.bench_data import Bench
from ssdo_gl.bench.measure import ErrorPanel, error_panels
from ssdo_gl.bench.presets import FIELDS, NAMES, PresetRung, read_ladder
from ssdo_gl.bench.report.cells import command_html, folded_command, number, table

# What the page asks for before the reader has typed anything; percent.
USUAL_MS, USUAL_PERCENT = 30.0, 5.0
# Frames a second, and errors in percent, that are answered in a table.
RATES = (60, 30, 10, 2)
PERCENTS = (20.0, 10.0, 5.0, 3.0)


def most_accurate_within(front: Sequence[Result], ms: float) -> Result | None:
    """Return the member of a front that is most accurate within a time; None if none is."""
    return next((r for r in reversed(front) if r.timing.ms.value <= ms), None)


def cheapest_within(front: Sequence[Result], panel: ErrorPanel, error: float) -> Result | None:
    """Return the member of a front that is fastest within an error; None if none is."""
    return next((r for r in front if r.verdicts[panel.name].error.value <= error), None)


def measured_panels(bench: Bench) -> list[ErrorPanel]:
    """Return the panels that any setting was held to."""
    return [p for p in error_panels() if any(p.name in r.verdicts for r in bench.results)]


def part_errors(panel: ErrorPanel, result: Result) -> dict[str, float]:
    """Return the error of each part that the scene has, worst first."""
    parts = result.verdicts[panel.name].scalars.parts
    return dict(sorted(((n, e) for n, e in parts.items() if e > 0.0), key=lambda item: -item[1]))


def card(bench: Bench, panel: ErrorPanel, result: Result) -> str:
    """Return all that a reader needs of a setting to take it."""
    verdict, ms = result.verdicts[panel.name], result.timing.ms
    low, high = (percent(e) for e in (verdict.error.low, verdict.error.high))
    parts = "".join(
        f"<dt>{escape(name)} alone</dt><dd>{percent(error)}</dd>"
        for name, error in part_errors(panel, result).items()
    )
    return (
        f'<p class="setting">{escape(result.point.label)}</p><dl>'
        f"<dt>error</dt><dd><b>{percent(verdict.error.value)}</b> "
        f"<small>{low} to {high}, 95 % sure</small></dd>"
        f"<dt>time</dt><dd><b>{number(ms.value)} ms</b> "
        f"<small>{number(ms.low)} to {number(ms.high)} ms, 95 % sure</small></dd>"
        f"<dt>nothing beats it</dt><dd>{sureness(verdict.confidence)} sure</dd>{parts}</dl>"
        f"{command_html(bench.command(result.point))}"
    )


def answer_data(bench: Bench) -> list[dict[str, Any]]:
    """Return the fronts for the page's script, which looks up what its reader types."""
    return [
        {
            "unit": "of the reference's mean" if panel.relative else f"of full {panel.aov}",
            "front": [
                {
                    "ms": result.timing.ms.value,
                    "error": result.verdicts[panel.name].error.value,
                    "card": f"{panel.name}-{place}",
                }
                for place, result in enumerate(front_of(bench.results, panel.name))
            ],
        }
        for panel in measured_panels(bench)
    ]


def answer_section(bench: Bench) -> str:
    """Return two questions, and a card for each answer that the page's script may give."""
    panels = measured_panels(bench)
    if not panels:
        return '<p class="note">No error was measured in this run.</p>'
    options = "".join(
        f'<option value="{i}">{escape(panel.title)}</option>' for i, panel in enumerate(panels)
    )
    boxes = "".join(
        f'<div class="answer"><label>{before} <input type="number" id="{name}" value="{value:g}" '
        f'min="0" step="any" inputmode="decimal"> {after}</label>'
        f'<div id="{name}-answer" aria-live="polite"></div></div>'
        for name, before, value, after in (
            ("have", "I have", USUAL_MS, "ms a frame"),
            ("bear", "I can bear", USUAL_PERCENT, "% error"),
        )
    )
    templates = "".join(
        f'<template id="card-{escape(panel.name)}-{place}">{card(bench, panel, result)}</template>'
        for panel in panels
        for place, result in enumerate(front_of(bench.results, panel.name))
    )
    width, height = bench.base.size
    return (
        f'<p class="with-js"><label>Judged by <select id="judge">{options}</select></label> '
        '<span class="note">errors are <span id="unit"></span></span></p>'
        f'<div class="answers">{boxes}</div>{templates}'
        f'<p class="note">For frames of {width}x{height} on this machine, one sample a pixel. '
        "Another size, camera or machine: run the bench there.</p>"
    )


def recommendations(bench: Bench) -> str:
    """Return what to take for pictures if no bound is known, by each of their references."""
    sentences = {p.title: recommend(bench.results, p.name).sentence
                 for p in measured_panels(bench) if p.is_picture}  # fmt: skip
    rows = "".join(f"<li>{escape(f'{k}: {v}.')}</li>" for k, v in sentences.items())
    return f"<p><b>No number in mind?</b></p><ul>{rows}</ul>" if rows else ""


def usual_answers(bench: Bench) -> str:
    """Return the answers to usual times and errors by the first panel, for paper."""
    panel = measured_panels(bench)[0]
    front = front_of(bench.results, panel.name)
    asked = [
        (f"{rate} frames a second: {1000 / rate:.3g} ms", most_accurate_within(front, 1000 / rate))
        for rate in RATES
    ]
    asked += [(f"{p:g} % error", cheapest_within(front, panel, p / 100.0)) for p in PERCENTS]
    rows = []
    for question, found in asked:
        if found is None:
            rows.append([question, "nothing measured", "", "", ""])
            continue
        rows.append(
            [
                question,
                escape(found.point.label),
                number(found.timing.ms.value),
                percent(found.verdicts[panel.name].error.value),
                folded_command(bench.command(found.point)),
            ]
        )
    return table(("bound", "setting", "ms", "error", "command"), rows, "Answers to usual bounds")


def presets_section(bench: Bench) -> str:
    """Return what presets and budgets are, and what presets take here where it was measured."""
    panel = measured_panels(bench)[0]
    ladder = read_ladder()
    rows = []
    for name in NAMES:
        command = folded_command(bench.asking(f"--preset {name}"))
        if name not in ladder.presets:
            rows.append([name, "rays until the standard error is 1 %", "", "1 %", "", "", command])
            continue
        rung = ladder.rungs[ladder.presets[name]]
        result = _at_rung(bench.results, rung)
        here = ["", ""]
        if result is not None and panel.name in result.verdicts:
            error = percent(result.verdicts[panel.name].error.value)
            here = [number(result.timing.ms.value), error]
        rows.append(
            [name, rung.label, f"{rung.relative_time:.2f}", percent(rung.error), *here, command]
        )
    head = ("preset", "is", "time, relative", "error, usual", "ms here", "error here", "command")
    return (
        f"<p>A preset is a fixed setting off the front of {len(ladder.source['benches'])} other "
        "benches; relative times are over those of the published method with 8 points. Empty: "
        f"not among the settings of this run.</p>{table(head, rows, 'Presets')}"
        "<p>A budget chooses for your scene and machine: <code>--budget-ms 30</code> times a few "
        "settings and takes the most accurate that fits a frame; <code>--max-error 0.05</code> "
        "measures errors against a short reference and takes the cheapest that stays below. "
        "Both say in one line what they chose.</p>"
        f"{command_html(bench.asking(f'--budget-ms {USUAL_MS:g}'))}"
        f"{command_html(bench.asking(f'--max-error {USUAL_PERCENT / 100.0:g}'))}"
    )


def _at_rung(results: Sequence[Result], rung: PresetRung) -> Result | None:
    def is_it(result: Result) -> bool:
        point = result.point
        return (
            point.method == "bounce"
            and point.radius_factor == 1.0
            and not point.overrides
            and all(getattr(point, name) == getattr(rung, name) for name in FIELDS)
        )

    return next(filter(is_it, results), None)


def parts_section(bench: Bench) -> str:
    """Return what the error of a whole picture hides: its parts' own, the worst as heading."""
    result = bench.recommendation.result
    if result is None:
        return ""
    sections = []
    for panel in measured_panels(bench):
        verdict = result.verdicts.get(panel.name)
        errors = part_errors(panel, result) if verdict is not None else {}
        if verdict is None or not errors:
            continue
        worst, error = next(iter(errors.items()))
        reference = bench.references.get(panel.name)
        floor = reference.floor_parts if reference is not None else {}
        figures = "".join(
            f'<li><b>{percent(value)}</b> {escape(name)}'
            + (f" <small>{percent(floor[name])} with the march converged</small>"
               if name in floor else "")
            + "</li>"
            for name, value in errors.items()
        )  # fmt: skip
        sections.append(
            f"<h2>{escape(worst.capitalize())} alone is {percent(error)} wrong, the picture "
            f"{percent(verdict.error.value)}</h2>"
            f"<p>Each part of the light against the same part of the {escape(panel.method)}, "
            f"relative to the part's own mean, with {escape(result.point.label)}. What is dim in "
            f'the picture can be far off and hardly show.</p><ul class="figures">{figures}</ul>'
        )
    return "".join(sections)
