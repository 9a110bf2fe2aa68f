"""Numbers, commands and tables as HTML."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from html import escape

from ssdo_gl.bench.analysis import three_digits
from ssdo_gl.bench.statistics import Interval


def number(value: float) -> str:
    """Return a number as tables show it; nothing for NaN."""
    if math.isnan(value):
        return ""
    return three_digits(value)


def interval_text(interval: Interval) -> str:
    """Return an estimate and its interval."""
    return f"{number(interval.value)} [{number(interval.low)}, {number(interval.high)}]"


def sortable(value: float) -> str:
    """Return a number as the page's script reads it; empty for NaN."""
    if math.isnan(value):
        return ""
    # JavaScript reads what overflows as infinity.
    return "1e999" if math.isinf(value) else f"{value:.6g}"


def command_html(command: str) -> str:
    """Return a command with a button that copies it; no line breaks within a flag."""
    words = (f"<span>{escape(w)}</span>" if w[:1] == "-" else escape(w) for w in command.split(" "))
    return (
        f'<span class="command"><code>{" ".join(words)}</code>'
        '<button type="button" class="copy with-js">Copy</button></span>'
    )


def folded_command(command: str) -> str:
    """Return a command that is shown when asked for, so that a table stays narrow."""
    return f"<details><summary>command</summary>{command_html(command)}</details>"


def table(head: Sequence[str], rows: Iterable[Sequence[str]], name: str = "") -> str:
    """Return a table whose first column stays in view; cells are HTML already.

    `name` says what it is, to those who do not see it.
    """
    top = "".join(f'<th scope="col">{cell}</th>' for cell in head)
    top = f"<thead><tr>{top}</tr></thead>" if any(head) else ""
    body = "".join("<tr>" + "".join(f"<td>{c}</td>" for c in row) + "</tr>" for row in rows)
    return scrolling(f"<table>{top}<tbody>{body}</tbody></table>", name)


def scrolling(content: str, name: str) -> str:
    """Return a box that scrolls, also by the keyboard, if its content is too wide."""
    label = f' role="region" aria-label="{escape(name)}" tabindex="0"' if name else ""
    return f'<div class="scroll"{label}>{content}</div>'
