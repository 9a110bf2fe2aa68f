"""Records what each hard case measured and prints it as a table at the end.

A plugin, and no ``conftest.py`` of this folder: where several processes share the tests, the
one that prints reads none of the folder.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest


@dataclass
class Row:
    """One line of the table: a case, over all methods that were tried with it."""

    unit: str
    bound: float
    worst: float = 0.0
    methods: set[str] = field(default_factory=set)

    def line(self, case: str, width: int) -> str:
        """Return the line; few methods by name, more by number."""
        names = ", ".join(sorted(self.methods))
        methods = names if len(names) <= METHODS_WIDTH else f"{len(self.methods)} methods"
        return (
            f"{case:{width}}  {methods:{METHODS_WIDTH}}  "
            f"{self.worst:10.3g}  {self.bound:10.3g}  {self.unit}"
        )


METHODS_WIDTH = 18
PROPERTY = "hard case"
# Title of a class of cases -> (case, unit) -> row.
_ROWS: dict[str, dict[tuple[str, str], Row]] = {}


@pytest.fixture
def record(request):
    """Return ``record(case, method, error, bound)``, which also asserts error <= bound."""
    title = request.module.__doc__.partition("\n")[0]

    def note(case: str, method: str, error: float, bound: float, unit: str = "") -> None:
        measured = (title, case, unit, method, float(error), float(bound))
        request.node.user_properties.append((PROPERTY, measured))
        assert error <= bound, f"{case}, {method}: {error:.3g} where {bound:.3g} is allowed"

    return note


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Add what a test measured to its rows."""
    for name, measured in report.user_properties if report.when == "call" else ():
        if name == PROPERTY:
            title, case, unit, method, error, bound = measured
            row = _ROWS.setdefault(title, {}).setdefault((case, unit), Row(unit, bound))
            row.worst = max(row.worst, error)
            row.bound = max(row.bound, bound)
            row.methods.add(method)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print one line for each case, class by class: methods tried, worst error, bound."""
    if not _ROWS:
        return
    terminalreporter.section("hard cases")
    width = max(len(case) for rows in _ROWS.values() for case, _ in rows)
    terminalreporter.write_line(
        f"{'case':{width}}  {'methods':{METHODS_WIDTH}}  {'worst':>10}  {'bound':>10}"
    )
    for title, rows in _ROWS.items():
        terminalreporter.write_line(f"\n{title}")
        for (case, _), row in sorted(rows.items()):
            terminalreporter.write_line(row.line(case, width))
