"""Plots of a bench, drawn without a display and without global state."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ssdo_gl.bench.analysis import Result, front_of, sureness, three_digits
from ssdo_gl.bench.bench_data import Bench
from ssdo_gl.bench.measure import CLOCK_NAMES, ErrorPanel, error_panels
from ssdo_gl.bench.report import key
from ssdo_gl.bench.report.charts import has_logarithm, short
from ssdo_gl.bench.report.figures import drawable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
    import matplotlib as mpl

    with mpl.rc_context(_STYLE):
        figure: Figure = draw(*arguments)
        return figure


def pareto_figure(bench: Bench) -> Figure:
    """Return error against time, log-log, one chart for each reference that was measured."""
    shown = [p for p in error_panels() if any(p.name in r.verdicts for r in bench.results)]
    return drawn_in_style(_pareto, bench, shown)


def _pareto(bench: Bench, panels: Sequence[ErrorPanel]) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.2 * max(len(panels), 1), 7.4), layout="constrained")
    charts = figure.subplots(1, max(len(panels), 1), squeeze=False)[0]
    for chart, panel in zip(charts, panels, strict=False):
        _pareto_chart(chart, bench, panel)
    return figure


def _pareto_chart(chart: Axes, bench: Bench, panel: ErrorPanel) -> None:
    plotted = drawable(bench.results, panel)
    groups: dict[tuple[str, str], list[Result]] = {}
    for result in plotted:
        name = key.color_name(result.point)
        groups.setdefault((result.point.method, name), []).append(result)
    for (method, name), members in groups.items():
        errors = [r.verdicts[panel.name].error for r in members]
        times = [r.timing.ms for r in members]
        chart.errorbar(
            [t.value for t in times],
            [e.value for e in errors],
            xerr=[[t.value - t.low for t in times], [t.high - t.value for t in times]],
            yerr=[[e.value - e.low for e in errors], [e.high - e.value for e in errors]],
            fmt=key.marker(method),
            color=key.COLORS[key.color_index(name)],
            markersize=4.5,
            elinewidth=0.6,
            label=f"{method}, {name}",
        )
    front = front_of(plotted, panel.name)
    _draw_front(chart, front, panel)
    reference = bench.references.get(panel.name)
    if reference is not None and has_logarithm(reference.floor):
        # What more depth reads cannot cross. Named in the legend: beside it points may lie.
        style: Any = {"color": "#666666", "linestyle": "--", "linewidth": 0.9}
        chart.axhline(reference.floor, label="the march, converged", **style)
    _log_axes(chart)
    width, height = bench.base.size
    chart.set_xlabel(f"frame time, ms ({CLOCK_NAMES[bench.clock]}), {width}x{height}")
    chart.set_ylabel(panel.error_label)
    chart.set_title(panel.title, fontsize=8.5, wrap=True)
    if plotted:
        # Below the chart, beside the front: anywhere in it points may lie.
        chart.legend(fontsize=7, loc="upper right", bbox_to_anchor=(1.0, -0.12), labelspacing=0.25)
    else:
        chart.text(0.3, 0.5, "no error that could be drawn", transform=chart.transAxes)
    lines = [
        f"{i:>2}  {r.point.label}: {three_digits(r.timing.ms.value)} ms, "
        f"{verdict.error.value:.3g} ({sureness(verdict.confidence)} sure)"
        for i, r in enumerate(front[:MAX_NUMBERED], 1)
        for verdict in [r.verdicts[panel.name]]
    ]
    chart.text(
        0.0, -0.14, "Pareto front\n" + "\n".join(lines), transform=chart.transAxes,
        fontsize=7, va="top", family="monospace",
    )  # fmt: skip


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
        axis.set_major_formatter(FuncFormatter(lambda value, _: short(value)))
        axis.set_minor_formatter(NullFormatter())
