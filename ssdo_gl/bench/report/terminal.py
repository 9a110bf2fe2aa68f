"""What a bench found, in ten lines on the terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from ssdo_gl.bench.analysis import Result, front_of, percent, recommend, sureness
from ssdo_gl.bench.bench_data import Bench
from ssdo_gl.bench.measure import ErrorPanel, error_panels

# With heading, reference and recommendation the whole says it in about ten lines.
MAX_ROWS = 5


def chosen_rows(front: Sequence[Result], always: Result | None) -> list[Result]:
    """Return at most `MAX_ROWS` members of a front, spread evenly, `always` among them."""
    if len(front) <= MAX_ROWS:
        return list(front)
    last = len(front) - 1
    picked = {round(i * last / (MAX_ROWS - 1)) for i in range(MAX_ROWS)}
    index = next((i for i, result in enumerate(front) if result is always), None)
    if index is not None and index not in picked:
        # Neither end gives way: they say what is cheapest and what is best.
        inner = sorted(picked - {0, last}, key=lambda i: abs(i - index))
        picked = (picked - {inner[0]}) | {index}
    return [front[i] for i in sorted(picked)]


def front_table(bench: Bench, panel: ErrorPanel) -> Table:
    """Return members of a panel's front as a table."""
    front = front_of(bench.results, panel.name)
    rows = chosen_rows(front, bench.recommendation.result)
    table = Table(box=None, padding=(0, 2))
    table.add_column("setting")
    for column in ("ms", "error [95 %]", "sure"):
        table.add_column(column, justify="right")
    for result in rows:
        verdict = result.verdicts[panel.name]
        error = verdict.error
        show = percent if panel.relative else lambda value: f"{value:.3g}"
        is_recommended = result is bench.recommendation.result
        table.add_row(
            escape(result.point.label),
            f"{result.timing.ms.value:.1f}",
            f"{show(error.value)} [{show(error.low)}, {show(error.high)}]",
            sureness(verdict.confidence),
            style="bold" if is_recommended else "",
        )
    return table


def print_summary(bench: Bench, console: Console) -> None:
    """Print the front against the near-field reference, its worth, and a recommendation."""
    panel = next(
        (p for p in error_panels() if any(p.name in r.verdicts for r in bench.results)),
        error_panels()[0],
    )
    measured = sum(panel.name in r.verdicts for r in bench.results)
    count = len(front_of(bench.results, panel.name))
    console.print(f"{panel.title}: {count} of {measured} settings are on the front", markup=False)
    console.print(front_table(bench, panel))
    reference = bench.references.get(panel.name)
    if reference is not None:
        console.print(
            escape(
                f"reference: {reference.method}, {reference.spp} spp, standard error "
                f"{reference.ratio:.2f} of the smallest error, subtracted"
            ),
            style="dim",
        )
    console.print(escape(bench.recommendation.sentence))
    all_light = recommend(bench.results, "gi")
    if all_light.result is not None:
        console.print(escape(f"of all light: {all_light.sentence}"))
    if bench.recommendation.result is not None:
        console.print(escape(bench.command(bench.recommendation.result.point)))
