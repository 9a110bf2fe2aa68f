"""Plots of a bench, drawn without a display and without global state."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ssdo_gl.bench.analysis import ReferenceSummary, Result, front_of
from ssdo_gl.bench.bench_data import Bench, Series
from ssdo_gl.bench.clock import CLOCK_NAMES
from ssdo_gl.bench.fit import fit_power_law
from ssdo_gl.bench.metrics import missing
from ssdo_gl.bench.panels import ErrorPanel, error_panels
from ssdo_gl.bench.points import families

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito's colours: told apart by colour-blind readers, too.
COLORS = (
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#999999", "#F0E442",
    "#000000",
)  # fmt: skip
MARKERS = "osD^vP*Xh<>"
# Fixed, so that the same data give the same bytes.
# Any: the stubs list every key of matplotlib as a literal.
_STYLE: Any = {
    "svg.hashsalt": "ssdo_gl",
    "svg.fonttype": "path",
    "font.size": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e5e5e5",
    "axes.axisbelow": True,
    "legend.frameon": False,
}
# A chart with more numbered members than this cannot be read.
MAX_NUMBERED = 14


def _figure(width: float, height: float) -> Figure:
    """Return an empty figure of the given size in inches."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise missing("matplotlib") from None
    return Figure(figsize=(width, height), layout="constrained")


def as_bytes(figure: Figure, kind: str) -> bytes:
    """Return the figure as ``svg`` or ``png``; the same figure gives the same bytes."""
    import matplotlib as mpl

    buffer = io.BytesIO()
    metadata: dict[str, Any] = {"Date": None} if kind == "svg" else {"Software": None}
    with mpl.rc_context(_STYLE):
        figure.savefig(buffer, format=kind, dpi=150, metadata=metadata)
    return buffer.getvalue()


def drawn_in_style(draw: Any, *arguments: Any) -> Figure:
    """Return ``draw(*arguments)`` with the style of this module in force."""
    try:
        import matplotlib as mpl
    except ImportError:
        raise missing("matplotlib") from None
    with mpl.rc_context(_STYLE):
        figure: Figure = draw(*arguments)
        return figure


def pareto_figure(bench: Bench) -> Figure:
    """Return error against time, log-log, one chart for each reference that was measured."""
    shown = [p for p in error_panels() if any(p.name in r.verdicts for r in bench.results)]
    return drawn_in_style(_pareto, bench, shown)


def _pareto(bench: Bench, panels: Sequence[ErrorPanel]) -> Figure:
    figure = _figure(6.2 * max(len(panels), 1), 7.4)
    charts = figure.subplots(1, max(len(panels), 1), squeeze=False)[0]
    for chart, panel in zip(charts, panels, strict=False):
        _pareto_chart(chart, bench, panel)
    return figure


def _pareto_chart(chart: Axes, bench: Bench, panel: ErrorPanel) -> None:
    results = [r for r in bench.results if panel.name in r.verdicts]
    plotted = [r for r in results if _can_be_plotted(r, panel)]
    names = families([r.point for r in results])
    for number, family in enumerate(names):
        members = [r for r in plotted if r.point.family == family]
        if not members:
            continue
        errors = [r.verdicts[panel.name].error for r in members]
        times = [r.timing.ms for r in members]
        chart.errorbar(
            [t.value for t in times],
            [e.value for e in errors],
            xerr=[[t.value - t.low for t in times], [t.high - t.value for t in times]],
            yerr=[[e.value - e.low for e in errors], [e.high - e.value for e in errors]],
            fmt=MARKERS[number % len(MARKERS)],
            color=COLORS[number % len(COLORS)],
            markersize=4.5,
            elinewidth=0.6,
            label=family,
        )
    front = front_of(plotted, panel.name)
    _draw_front(chart, front, panel)
    reference = bench.references.get(panel.name)
    if reference is not None:
        _draw_limits(chart, reference)
    _log_axes(chart)
    chart.set_xlabel(_time_label(bench))
    chart.set_ylabel(panel.error_label)
    chart.set_title(panel.title, fontsize=8.5, wrap=True)
    if plotted:
        chart.legend(fontsize=7, loc="upper right")
    else:
        chart.text(0.3, 0.5, "no error that could be drawn", transform=chart.transAxes)
    lines = [
        f"{i + 1:>2}  {r.point.label}: {r.timing.ms.value:.3g} ms, "
        f"{r.verdicts[panel.name].error.value:.3g} ({r.verdicts[panel.name].confidence:.0%} sure)"
        for i, r in enumerate(front[:MAX_NUMBERED])
    ]
    chart.text(
        0.0, -0.14, "Pareto front\n" + "\n".join(lines), transform=chart.transAxes,
        fontsize=7, va="top", family="monospace",
    )  # fmt: skip


def _can_be_plotted(result: Result, panel: ErrorPanel) -> bool:
    """Whether both coordinates have a logarithm."""
    error, time = result.verdicts[panel.name].error, result.timing.ms
    return 0.0 < error.value < math.inf and 0.0 < time.value < math.inf


def _draw_front(chart: Axes, front: Sequence[Result], panel: ErrorPanel) -> None:
    if not front:
        return
    x = [r.timing.ms.value for r in front]
    y = [r.verdicts[panel.name].error.value for r in front]
    chart.step(x, y, where="post", color="black", linewidth=1.0, zorder=1)
    for number, (a, b) in enumerate(zip(x[:MAX_NUMBERED], y[:MAX_NUMBERED], strict=True)):
        chart.annotate(
            str(number + 1), (a, b), xytext=(-5, -9), textcoords="offset points",
            fontsize=7, fontweight="bold",
        )  # fmt: skip


def _draw_limits(chart: Axes, reference: ReferenceSummary) -> None:
    """Draw what more depth reads cannot cross."""
    if math.isfinite(reference.floor) and reference.floor > 0.0:
        chart.axhline(reference.floor, color="#666666", linestyle="--", linewidth=0.9)
        chart.annotate(
            "the march, converged", (0.01, reference.floor), fontsize=6.5, color="#666666",
            xycoords=("axes fraction", "data"), xytext=(2, 2), textcoords="offset points",
        )  # fmt: skip


def _log_axes(chart: Axes) -> None:
    """Make both axes logarithmic, with ticks like 0.05 and 20k, few enough to read.

    An axis without positive data stays linear: it has no logarithm.
    """
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    for name, axis in (("x", chart.xaxis), ("y", chart.yaxis)):
        low, high = axis.get_minpos(), axis.get_data_interval()[1]
        if not (0.0 < low <= high < math.inf):
            continue
        chart.set(**{f"{name}scale": "log"})
        # Over more than two decades 2 and 5 would crowd the axis.
        subs = (1.0, 2.0, 5.0) if high < 100.0 * low else (1.0,)
        axis.set_major_locator(LogLocator(base=10.0, subs=subs))
        axis.set_major_formatter(FuncFormatter(lambda value, _: _short(value)))
        axis.set_minor_formatter(NullFormatter())


def _short(value: float) -> str:
    """Return a tick's label: 0.05, 20, 40k, 1M."""
    for unit, letter in ((1e6, "M"), (1e3, "k")):
        if value >= unit:
            return f"{value / unit:g}{letter}"
    return f"{value:g}"


def _time_label(bench: Bench) -> str:
    return f"frame time, ms ({CLOCK_NAMES[bench.clock]}), {bench.base.size[0]}x{bench.base.size[1]}"


def samples_figure(bench: Bench) -> Figure:
    """Return error against samples of the unfiltered families, with the slope -1/2."""
    return drawn_in_style(_samples, bench)


def _samples(bench: Bench) -> Figure:
    # Of panels of one kind the first one stands for all.
    panels = list({panel.kind: panel for panel in reversed(error_panels())}.values())[::-1]
    figure = _figure(6.0 * len(panels), 4.6)
    charts = figure.subplots(1, len(panels), squeeze=False)[0]
    for chart, panel in zip(charts, panels, strict=True):
        chart.plot([], [], color="#cccccc", linewidth=3, label="slope -1/2")
        results = [
            r
            for r in bench.results
            if panel.name in r.verdicts and r.point.estimator and r.point.filter == "none"
        ]
        for number, family in enumerate(families([r.point for r in results])):
            members = sorted(
                (r for r in results if r.point.family == family), key=lambda r: r.point.samples
            )
            _samples_curves(chart, members, panel, COLORS[number % len(COLORS)], family)
        _log_axes(chart)
        chart.set_xlabel("depth reads per pixel")
        chart.set_ylabel(panel.error_label)
        chart.set_title(f"{panel.aov}: noise falls, what is systematic stays", fontsize=9)
        chart.legend(fontsize=7)
    return figure


def _samples_curves(
    chart: Axes, members: Sequence[Result], panel: ErrorPanel, color: str, family: str
) -> None:
    x = [r.point.samples for r in members]
    scalars = [r.verdicts[panel.name].scalars for r in members]
    noise = [s.noise for s in scalars]
    law = fit_power_law(x, noise)
    slope = f", noise ~ N^({law})" if law else ""
    total = [r.verdicts[panel.name].error.value for r in members]
    chart.plot(x, total, "-o", color=color, markersize=4, label=f"{family}: total{slope}")
    chart.plot(x, [s.systematic for s in scalars], "--", color=color, linewidth=1)
    chart.plot(x, noise, ":s", color=color, markersize=3, linewidth=1)
    usable = [(a, b) for a, b in zip(x, noise, strict=True) if 0.0 < b < math.inf]
    if usable:
        first, level = usable[0]
        guide = [level * math.sqrt(first / a) for a in x]
        chart.plot(x, guide, color="#cccccc", linewidth=3, zorder=0)


def scaling_figure(bench: Bench) -> Figure:
    """Return cost against samples, pixels, radius and triangles, with fitted exponents."""
    return drawn_in_style(_scaling, bench.series, CLOCK_NAMES[bench.clock])


def _scaling(series: Sequence[Series], clock: str) -> Figure:
    columns = 2 if len(series) > 1 else 1
    rows = max(1, -(-len(series) // columns))
    figure = _figure(7.0 * columns, 3.4 * rows)
    charts = figure.subplots(rows, columns, squeeze=False).ravel()
    for chart, item in zip(charts, series, strict=False):
        for number, (name, values) in enumerate(item.curves.items()):
            law = fit_power_law(item.x, values)
            label = f"{name}: {law}" if law else name
            style = MARKERS[number % len(MARKERS)]
            chart.plot(item.x, values, f"-{style}", color=COLORS[number % len(COLORS)],
                       markersize=4, label=label)  # fmt: skip
        _log_axes(chart)
        chart.set_xlabel(item.x_label)
        chart.set_ylabel(f"ms ({clock})")
        chart.legend(fontsize=7, title="exponent", loc="center left", bbox_to_anchor=(1.0, 0.5))
    for chart in charts[len(series) :]:
        chart.set_visible(False)
    return figure


def split_figure(bench: Bench, results: Sequence[Result]) -> Figure:
    """Return where the time of some points goes, pass by pass, as stacked bars."""
    return drawn_in_style(_split, bench, results)


def _split(bench: Bench, results: Sequence[Result]) -> Figure:
    from matplotlib import colormaps

    rows = [(r.point.label, bench.splits[r.point.key]) for r in results]
    names = list(dict.fromkeys(name for _, split in rows for name, _ in split))
    figure = _figure(11.0, 1.4 + 0.32 * max(len(rows), 1))
    chart = figure.subplots()
    left = [0.0] * len(rows)
    for number, name in enumerate(names):
        widths = [dict(split).get(name, 0.0) for _, split in rows]
        chart.barh(
            range(len(rows)), widths, left=left, height=0.7, label=name,
            color=colormaps["tab20"](number % 20),
        )  # fmt: skip
        left = [a + b for a, b in zip(left, widths, strict=True)]
    chart.set_yticks(range(len(rows)), [label for label, _ in rows])
    chart.invert_yaxis()
    chart.set_xlabel(f"ms ({CLOCK_NAMES[bench.clock]}), each pass waited for")
    chart.grid(axis="y", visible=False)
    figure.legend(fontsize=7, ncols=6, loc="outside lower center")
    return figure
