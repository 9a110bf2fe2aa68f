"""Records what each hard case measured and prints it as a table at the end."""

from __future__ import annotations

import pytest

_ROWS: dict[tuple[str, str], tuple[float, float, set[str]]] = {}


@pytest.fixture
def record():
    """Return ``record(case, method, error, bound)``, which also asserts error <= bound."""

    def note(case: str, method: str, error: float, bound: float, unit: str = "") -> None:
        worst, _, methods = _ROWS.get((case, unit), (0.0, bound, set()))
        _ROWS[case, unit] = max(worst, float(error)), bound, methods | {method}
        assert error <= bound, f"{case}, {method}: {error:.3g} where {bound:.3g} is allowed"

    return note


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print one line for each case: methods tried, worst error, bound."""
    if not _ROWS:
        return
    terminalreporter.section("hard cases")
    width = max(len(case) for case, _ in _ROWS)
    terminalreporter.write_line(f"{'case':{width}}  methods  worst error      bound")
    for (case, unit), (worst, bound, methods) in sorted(_ROWS.items()):
        terminalreporter.write_line(
            f"{case:{width}}  {len(methods):7d}  {worst:11.3g}  {bound:9.3g} {unit}"
        )
