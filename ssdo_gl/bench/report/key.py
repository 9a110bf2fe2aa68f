"""One key for all charts: colour says the estimator, shape the method, hollow no filter."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from ssdo_gl.bench.measure import Point
from ssdo_gl.bench.scaling import PARTS
from ssdo_gl.settings.estimators import ESTIMATORS
from ssdo_gl.settings.methods import METHODS

# (on light paper, on dark paper). Colour-blind readers tell them apart with the shapes' help.
_COLORS = (
    ("#0072B2", "#56B4E9"), ("#D55E00", "#FF9248"), ("#009E73", "#3FD1A5"),
    ("#A87900", "#E6B422"), ("#8E4BB8", "#C494E8"), ("#C4457F", "#F08DB8"),
    ("#5B7F1A", "#A5CB4F"), ("#6B4F3A", "#C9A58A"),
)  # fmt: skip
_RAYS, _NONE = ("#111111", "#F5F5F5"), ("#777777", "#9AA4B0")
# What is no estimator, before those that are.
_OTHERS = ("no estimator", "rays")
COLORS = tuple(light for light, _ in (_NONE, _RAYS, *_COLORS))
# Of matplotlib, in the order of `METHODS`: the bounce is the circle.
MARKERS = "Ps^oDX*v"
# The same as paths around the origin.
_SHAPES = {
    "o": "M-1 0A1 1 0 1 0 1 0A1 1 0 1 0-1 0Z",
    "s": "M-.9-.9H.9V.9H-.9Z",
    "^": "M0-1.15L1.1.85H-1.1Z",
    "D": "M0-1.25L1.25 0L0 1.25L-1.25 0Z",
    "v": "M0 1.15L1.1-.85H-1.1Z",
    "P": "M-.4-1.2H.4V-.4H1.2V.4H.4V1.2H-.4V.4H-1.2V-.4H-.4Z",
    "X": "M-1.13-.57L-.57-1.13L0-.57L.57-1.13L1.13-.57L.57 0L1.13.57L.57 1.13L0 .57L-.57 1.13"
         "L-1.13.57L-.57 0Z",
    "*": "M0-1.4L.33-.45L1.33-.43L.53.17L.82 1.13L0 .56L-.82 1.13L-.53.17L-1.33-.43L-.33-.45Z",
}  # fmt: skip
# The parts of a frame are none of the above, so they have colours of their own.
_PART_COLORS = (
    ("#4E79A7", "#7DA7D6"), ("#F28E2B", "#FFB066"), ("#E1B000", "#F2D04A"),
    ("#59A14F", "#84CB7A"), ("#B07AA1", "#D5A6C9"), ("#9C755F", "#C9A48F"),
    ("#2A9D9D", "#5FD0CF"), ("#111111", "#F5F5F5"), ("#E15759", "#FF8A8C"),
    ("#7A5CC0", "#B79CF0"),
)  # fmt: skip
PART_NAMES = (*dict.fromkeys(PARTS.values()), "rest", "whole frame")


def color_name(point: Point) -> str:
    """Return what the colour of a point stands for."""
    return point.estimator or _OTHERS[METHODS[point.method].is_reference]


def color_index(name: str) -> int:
    """Return the place in `COLORS` of what `color_name` returns."""
    if name in _OTHERS:
        return _OTHERS.index(name)
    return len(_OTHERS) + list(ESTIMATORS).index(name) % len(_COLORS)


def marker(method: str) -> str:
    """Return the marker of a method, as matplotlib calls it."""
    return MARKERS[list(METHODS).index(method) % len(MARKERS)]


def part_index(name: str) -> int:
    """Return the colour of a part of the frame; parts without a name of ours share the last."""
    return PART_NAMES.index(name) if name in PART_NAMES else len(_PART_COLORS) - 1


def css_colors(*, dark: bool = False) -> str:
    """Return the key's colours as declarations of CSS variables ``--c0`` and ``--p0``."""
    tables = {"c": (_NONE, _RAYS, *_COLORS), "p": _PART_COLORS}
    return "".join(
        f"--{letter}{i}:{pair[dark]};" for letter, table in tables.items()
        for i, pair in enumerate(table)
    )  # fmt: skip


def css_classes() -> str:
    """Return the rules that give ``c0`` and ``p0`` their colours."""
    counts = {"c": len(COLORS), "p": len(_PART_COLORS)}
    return "".join(
        f".{letter}{i}{{--c:var(--{letter}{i})}}" for letter, n in counts.items() for i in range(n)
    )


def mark(method: str, classes: str, x: float = 0.0, y: float = 0.0, size: float = 4.5) -> str:
    """Return an SVG element: the shape of a method; `classes` give it its colour."""
    return (
        f'<path class="mark {classes}" d="{_SHAPES[marker(method)]}" '
        f'transform="translate({x:.1f} {y:.1f}) scale({size:g})"/>'
    )


def point_mark(point: Point, x: float, y: float) -> str:
    """Return the mark of a measured point at a place of a chart."""
    hollow = " hollow" if point.estimator and point.filter == "none" else ""
    classes = f"c{color_index(color_name(point))}{hollow}"
    return mark(point.method, classes, x, y, 4.5 if point.resolution_scale == 1.0 else 3.2)


def entries(points: Sequence[Point]) -> list[tuple[str, str]]:
    """Return the key of some points as (SVG element around the origin, text)."""
    colors = sorted({color_name(point) for point in points}, key=color_index)
    found = [(mark("bounce", f"c{color_index(name)}"), name) for name in colors]
    methods = [name for name in METHODS if any(p.method == name for p in points)]
    found += [(mark(name, "plain"), name) for name in methods]
    found.append((mark("bounce", "plain hollow"), "no filter"))
    found.append((mark("bounce", "plain", size=3.2), "half resolution"))
    return found


def part_entries(names: Iterable[str]) -> list[tuple[str, str]]:
    """Return the key of parts of the frame as (SVG element around the origin, text)."""
    box = '<path class="mark p{}" d="M-5-5H5V5H-5Z"/>'
    return [(box.format(part_index(n)), n) for n in sorted({*names}, key=part_index)]


def key_html(rows: Sequence[tuple[str, str]]) -> str:
    """Return a key as a list."""
    items = "".join(
        f'<li><svg class="swatch" viewBox="-7 -7 14 14" aria-hidden="true">{element}</svg>'
        f"{escape(text)}</li>"
        for element, text in rows
    )
    return f'<ul class="key">{items}</ul>'
