"""The charts of a report: fronts, samples, growth, and where the time goes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

from ssdo_gl.bench.analysis import Result, front_of, percent, sureness, three_digits
from ssdo_gl.bench.bench_data import Bench, Series
from ssdo_gl.bench.measure import CLOCK_NAMES, ErrorPanel, error_panels
from ssdo_gl.bench.report import key
from ssdo_gl.bench.report.charts import (
    WIDTH,
    Figure,
    LogChart,
    has_logarithm,
    svg_element,
)
from ssdo_gl.bench.scaling import PARTS
from ssdo_gl.bench.statistics import fit_power_law

# Numbers beside dots that are closer than this would cover each other.
_NUMBER_GAP = 11.0


def error_text(panel: ErrorPanel, value: float) -> str:
    """Return an error as a person writes it, in the panel's unit."""
    return percent(value) if panel.relative else f"{value:.3g}"


def drawable(results: Sequence[Result], panel: ErrorPanel) -> list[Result]:
    """Return the results of a panel whose time and error both have a logarithm."""
    return [
        r
        for r in results
        if panel.name in r.verdicts
        and has_logarithm(r.verdicts[panel.name].error.value)
        and has_logarithm(r.timing.ms.value)
    ]


def front_chart(bench: Bench, panel: ErrorPanel) -> Figure:
    """Return error against time of one panel."""
    results = drawable(bench.results, panel)
    reference = bench.references.get(panel.name)
    floor = reference.floor if reference is not None else math.nan
    errors = [r.verdicts[panel.name].error.value for r in results]
    times = [r.timing.ms.value for r in results]
    levels = [floor] if has_logarithm(floor) else []
    chart = LogChart(
        panel.title, f"frame time, ms ({CLOCK_NAMES[bench.clock]})", panel.error_label,
        times, errors + levels, percent=panel.relative,
    )  # fmt: skip
    for level in levels:
        chart.level(level, "the march, converged", list(zip(times, errors, strict=True)))
    front = front_of(results, panel.name)
    _stair(chart, front, panel)
    for result in sorted(results, key=lambda r: r.verdicts[panel.name].on_front):
        chart.add(_dot(chart, result, panel))
    _numbers(chart, front, panel)
    if not results:
        chart.add('<text x="120" y="150">no error that could be drawn</text>')
    return Figure(panel.title, chart.svg())


def _stair(chart: LogChart, front: Sequence[Result], panel: ErrorPanel) -> None:
    path = ""
    for result in front:
        x, y = chart.place(result.timing.ms.value, result.verdicts[panel.name].error.value)
        path += f"H{x:.1f}V{y:.1f}" if path else f"M{x:.1f} {y:.1f}"
    if path:
        chart.add(f'<path class="stair" d="{path}"/>')


def _dot(chart: LogChart, result: Result, panel: ErrorPanel) -> str:
    verdict, time = result.verdicts[panel.name], result.timing.ms
    x, y = chart.place(time.value, verdict.error.value)
    left, right = (chart.place(t, verdict.error.value)[0] for t in (time.low, time.high))
    low, high = (chart.place(time.value, e)[1] for e in (verdict.error.low, verdict.error.high))
    tip = (
        f"{result.point.label}\n{three_digits(time.value)} ms, error "
        f"{error_text(panel, verdict.error.value)}\n"
        f"on the front: {sureness(verdict.confidence)} sure"
    )
    # Those on the front can be reached by the keyboard; all are rows of a table as well.
    front = ' front" tabindex="0" role="button' if verdict.on_front else ""
    color = key.color_index(key.color_name(result.point))
    return (
        f'<g class="dot{front}" data-label="{escape(result.point.label)}">'
        f"<title>{escape(tip)}</title>"
        f'<path class="whisker c{color}" d="M{left:.1f} {y:.1f}H{right:.1f}'
        f'M{x:.1f} {low:.1f}V{high:.1f}"/>{key.point_mark(result.point, x, y)}</g>'
    )


def _numbers(chart: LogChart, front: Sequence[Result], panel: ErrorPanel) -> None:
    """Number the members of a front as its table does, where there is room."""
    last = (-math.inf, -math.inf)
    for number, result in enumerate(front, 1):
        x, y = chart.place(result.timing.ms.value, result.verdicts[panel.name].error.value)
        if math.dist(last, (x, y)) >= _NUMBER_GAP:
            chart.add(
                f'<text class="small" x="{x - 6:.1f}" y="{y + 13:.1f}" text-anchor="end">'
                f"{number}</text>"
            )
            last = (x, y)


def samples_charts(bench: Bench) -> list[Figure]:
    """Return error against samples of unfiltered points, a chart for each kind."""
    # Of panels of one kind the first one stands for all.
    panels = {panel.kind: panel for panel in reversed(error_panels())}
    found = []
    for panel in reversed(panels.values()):
        groups: dict[tuple[str, str], list[Result]] = {}
        for result in sorted(bench.results, key=lambda r: r.point.samples):
            point = result.point
            if panel.name in result.verdicts and point.estimator and point.filter == "none":
                groups.setdefault((point.method, point.estimator), []).append(result)
        # A single point is no curve.
        groups = {name: members for name, members in groups.items() if len(members) > 1}
        if groups:
            title = f"{panel.kind}: noise falls, what is systematic stays"
            found.append(_samples_chart(title, groups, panel))
    return found


def _samples_chart(
    title: str, groups: dict[tuple[str, str], list[Result]], panel: ErrorPanel
) -> Figure:
    members = [r for group in groups.values() for r in group]
    scalars = [r.verdicts[panel.name].scalars for r in members]
    chart = LogChart(
        title, "depth reads per pixel", panel.error_label, [r.point.samples for r in members],
        [value for s in scalars for value in (s.noise, s.systematic)]
        + [r.verdicts[panel.name].error.value for r in members],
        percent=panel.relative,
    )  # fmt: skip
    laws = []
    for (method, estimator), group in groups.items():
        xs = [float(r.point.samples) for r in group]
        judged = [r.verdicts[panel.name] for r in group]
        noise = [verdict.scalars.noise for verdict in judged]
        color = f"c{key.color_index(estimator)}"
        usable = [(x, v) for x, v in zip(xs, noise, strict=True) if has_logarithm(v)]
        if usable:
            first, level = usable[0]
            chart.curve(xs, [level * math.sqrt(first / x) for x in xs], "guide")
        totals = [verdict.error.value for verdict in judged]
        chart.curve(xs, noise, f"curve dotted {color}")
        chart.curve(xs, [v.scalars.systematic for v in judged], f"curve dashed {color}")
        chart.curve(xs, totals, f"curve {color}")
        for result, x, total in zip(group, xs, totals, strict=True):
            if has_logarithm(total):
                chart.add(key.point_mark(result.point, *chart.place(x, total)))
        law = fit_power_law(xs, noise)
        laws.append(f"{method} {estimator}: noise ~ N^({law})" if law else "")
    return Figure(title, chart.svg(), "; ".join(filter(None, laws)))


def scaling_charts(bench: Bench) -> list[Figure]:
    """Return cost against samples, pixels, radius and triangles, with fitted exponents."""
    return [_scaling_chart(s, bench.clock) for s in bench.series]


def _scaling_chart(series: Series, clock: str) -> Figure:
    values = [value for curve in series.curves.values() for value in curve]
    title = f"ms ({CLOCK_NAMES[clock]})"
    chart = LogChart(series.name, series.x_label, title, series.x, values)
    laws = []
    for name, curve in series.curves.items():
        chart.curve(series.x, curve, f"curve p{key.part_index(name)}")
        law = fit_power_law(series.x, curve)
        if law:
            laws.append(f"{name} {law}")
    text = f"Exponents: {'; '.join(laws)}." if laws else ""
    return Figure(f"Time against {series.x_label}", chart.svg(), text)


def split_chart(bench: Bench, results: Sequence[Result]) -> Figure:
    """Return where the time of some points goes, pass by pass, as stacked bars."""
    rows = [(r.point.label, bench.splits[r.point.key]) for r in results]
    longest = max((sum(ms for _, ms in split) for _, split in rows), default=0.0) or 1.0
    scale, row_height = (WIDTH - 55.0) / longest, 34.0
    elements = []
    for number, (label, split) in enumerate(rows):
        x, y = 0.0, number * row_height
        elements.append(f'<text x="0" y="{y + 12:.1f}">{escape(label)}</text>')
        for name, ms in split:
            part = key.part_index(PARTS.get(name, "rest"))
            elements.append(
                f'<rect class="bar p{part}" x="{x:.2f}" y="{y + 16:.1f}" '
                f'width="{ms * scale:.2f}" height="13">'
                f"<title>{escape(name)}: {three_digits(ms)} ms</title></rect>"
            )
            x += ms * scale
        total = f"{three_digits(x / scale)} ms"
        elements.append(f'<text class="small" x="{x + 4:.1f}" y="{y + 27:.1f}">{total}</text>')
    height, title = max(len(rows), 1) * row_height, "Time by pass"
    return Figure(title, svg_element("".join(elements), height, title))
