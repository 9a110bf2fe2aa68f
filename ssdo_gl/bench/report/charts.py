"""Draws charts with two logarithmic axes as SVG, which a page styles as it does its text."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

# About as wide as a telephone and as a third of the page, so that text is as large as the page's.
WIDTH, HEIGHT = 400.0, 310.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 58.0, 12.0, 10.0, 42.0
# Width of a letter of small text, about.
_LETTER = 5.3
# Rules for what is drawn here; colours are variables, so that dark pages can set others.
CHART_CSS = (
    "svg.chart{font:12px system-ui,sans-serif;display:block}"
    ".chart text{fill:var(--ink)}.chart .small{font-size:10.5px}"
    ".chart .grid{stroke:var(--line);fill:none}.chart .stair{stroke:var(--ink);fill:none}"
    ".chart .limit{stroke:var(--soft);stroke-dasharray:5 4;fill:none}"
    ".chart .curve{stroke:var(--c);fill:none;stroke-width:1.8}"
    ".chart .dotted{stroke-dasharray:1.5 3}.chart .dashed{stroke-dasharray:6 4}"
    ".chart .guide{stroke:var(--line);stroke-width:4;fill:none}"
    ".chart .whisker{stroke:var(--c);fill:none;opacity:.6}"
    ".mark{fill:var(--c);stroke:var(--c);stroke-width:.3}.hollow{fill:var(--wash)}"
    ".mark.hollow{stroke-width:.45}.plain{--c:var(--ink)}"
    ".chart .bar{fill:var(--c);stroke:var(--wash);stroke-width:.6}"
    ".dot{opacity:.75}.dot.front{opacity:1}.dot.front .number{font-weight:700}"
)
LIGHT = "--ink:#1b1e23;--soft:#5b6470;--line:#d9dde2;--paper:#ffffff;--wash:#f4f6f8;"
DARK = "--ink:#e6e8eb;--soft:#9aa4b0;--line:#3a414a;--paper:#16191d;--wash:#1f242a;"


def has_logarithm(value: float) -> bool:
    """Whether a value can be drawn."""
    return 0.0 < value < math.inf


def short(value: float) -> str:
    """Return a tick's label: 0.05, 20, 40k, 1M."""
    for unit, letter in ((1e6, "M"), (1e3, "k")):
        if value >= unit:
            return f"{value / unit:g}{letter}"
    return f"{value:g}"


def log_ticks(low: float, high: float) -> list[float]:
    """Return round numbers within a range: 1, 2 and 5 of each decade, of many only 1."""
    steps = (1.0, 2.0, 5.0) if high < 200.0 * low else (1.0,)
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    return [v for e in decades for m in steps if low <= (v := float(f"{m:g}e{e}")) <= high]


class LogChart:
    """A chart in the making.

    Parameters
    ----------
    xs, ys : sequence of float
        What has to be inside; values without a logarithm do not count.
    percent : bool
        Whether `ys` are shares.
    """

    def __init__(
        self,
        title: str,
        x_label: str,
        y_label: str,
        xs: Sequence[float],
        ys: Sequence[float],
        *,
        percent: bool = False,
    ) -> None:
        self.title, self.percent = title, percent
        self.x_range, self.y_range = _range(xs), _range(ys)
        self._elements = _frame(self, x_label, y_label)

    def place(self, x: float, y: float) -> tuple[float, float]:
        """Return where a pair is drawn; what is beyond the range, at its edge."""
        return (
            _LEFT + (WIDTH - _LEFT - _RIGHT) * _share(x, self.x_range),
            HEIGHT - _BOTTOM - (HEIGHT - _TOP - _BOTTOM) * _share(y, self.y_range),
        )

    def add(self, element: str) -> None:
        """Draw an SVG element over what is there."""
        self._elements.append(element)

    def curve(self, xs: Sequence[float], ys: Sequence[float], classes: str) -> None:
        """Draw lines between those pairs that have a logarithm."""
        places = [
            self.place(x, y)
            for x, y in zip(xs, ys, strict=True)
            if has_logarithm(x) and has_logarithm(y)
        ]
        if places:
            path = "L".join(f"{x:.1f} {y:.1f}" for x, y in places)
            self.add(f'<path class="{classes}" d="M{path}"/>')

    def level(self, y: float, text: str, points: Sequence[tuple[float, float]] = ()) -> None:
        """Draw a line across at `y`, named at the end where fewer `points` cover its name."""
        left, height = self.place(self.x_range[0], y)
        self.add(f'<path class="limit" d="M{left:.1f} {height:.1f}H{WIDTH - _RIGHT}"/>')
        # Little is below what more reads cannot cross.
        below = height + 13.0 if height + 16.0 < HEIGHT - _BOTTOM else height - 4.0
        wide, right = _LETTER * len(text), WIDTH - _RIGHT
        # Dots are some 8 across, and have numbers beside them.
        places = [x for x, v in (self.place(*p) for p in points) if abs(v - below + 4.0) < 14.0]
        covering = [sum(a < x < b for x in places) for a, b in (
            (left - 6.0, left + wide + 9.0), (right - wide - 9.0, right + 6.0),
        )]  # fmt: skip
        x, anchor = (right - 3.0, "end") if covering[1] < covering[0] else (left + 3.0, "start")
        self.add(
            f'<text class="small" x="{x:.1f}" y="{below:.1f}" text-anchor="{anchor}">'
            f"{escape(text)}</text>"
        )

    def svg(self) -> str:
        """Return the chart as an element of a page."""
        return svg_element("".join(self._elements), HEIGHT, self.title)


def svg_element(content: str, height: float, title: str) -> str:
    """Return an ``svg`` element of the usual width."""
    return (
        f'<svg class="chart" viewBox="0 0 {WIDTH:g} {height:g}" role="group" '
        f'aria-label="{escape(title)}">{content}</svg>'
    )


@dataclass(frozen=True)
class Figure:
    """A chart of a page, and what is said above and below it."""

    title: str
    svg: str
    note: str = ""


def _range(values: Sequence[float]) -> tuple[float, float]:
    usable = [value for value in values if has_logarithm(value)] or [1.0]
    return min(usable) / 1.25, max(usable) * 1.25


def _share(value: float, limits: tuple[float, float]) -> float:
    low, high = limits
    return math.log(min(max(value, low), high) / low) / math.log(high / low)


def _frame(chart: LogChart, x_label: str, y_label: str) -> list[str]:
    """Return grid, ticks and names of the axes."""
    floor, right = HEIGHT - _BOTTOM, WIDTH - _RIGHT

    def text(content: str, x: float, y: float, anchor: str) -> str:
        return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(content)}</text>'

    elements = []
    for value in log_ticks(*chart.x_range):
        x, _ = chart.place(value, chart.y_range[0])
        elements.append(f'<path class="grid" d="M{x:.1f} {_TOP}V{floor}"/>')
        elements.append(text(short(value), x, floor + 15.0, "middle"))
    for value in log_ticks(*chart.y_range):
        _, y = chart.place(chart.x_range[0], value)
        name = f"{100.0 * value:g} %" if chart.percent else short(value)
        elements.append(f'<path class="grid" d="M{_LEFT} {y:.1f}H{right}"/>')
        elements.append(text(name, _LEFT - 5.0, y + 4.0, "end"))
    elements.append(text(x_label, 0.5 * (_LEFT + right), HEIGHT - 7.0, "middle"))
    turned = f"translate(11 {0.5 * (_TOP + floor):.1f}) rotate(-90)"
    elements.append(f'<g transform="{turned}">{text(y_label, 0.0, 0.0, "middle")}</g>')
    return elements
