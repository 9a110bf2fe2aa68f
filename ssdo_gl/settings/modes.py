"""What the command can be asked to do; each flag says in which of these it has an effect."""

from __future__ import annotations

WINDOW, SNAPSHOT, EXPLAIN, BENCH = "window", "snapshot", "explain", "bench"
# How messages call each mode.
MODES = {
    WINDOW: "the window",
    SNAPSHOT: "--snapshot OUT",
    EXPLAIN: "--explain",
    BENCH: "--bench OUTDIR",
}
ALL = frozenset(MODES)
# One rendering, as against the many of a bench.
ONE = frozenset({WINDOW, SNAPSHOT, EXPLAIN})
HEADLESS = frozenset({SNAPSHOT, EXPLAIN})
