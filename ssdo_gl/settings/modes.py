"""What the command can be asked to do; each flag says in which of these it has an effect."""

from __future__ import annotations

WINDOW, SNAPSHOT, EXPLAIN, BENCH = "window", "snapshot", "explain", "bench"
BATCH, FILM, SERVE = "batch", "film", "serve"
# How messages call each mode.
MODES = {
    WINDOW: "the window",
    SNAPSHOT: "--snapshot OUT",
    EXPLAIN: "--explain",
    BENCH: "--bench OUTDIR",
    BATCH: "--batch",
    FILM: "--film OUT",
    SERVE: "--serve",
}
ALL = frozenset(MODES)
# One way to render, as against the many of a bench.
ONE = frozenset({WINDOW, SNAPSHOT, EXPLAIN, BATCH, FILM, SERVE})
# Somebody flies through the scene.
LIVE = frozenset({WINDOW, SERVE})
# Whatever makes pictures of a size of its own: a page says how large it is.
SIZED = ALL - {SERVE}
HEADLESS = frozenset({SNAPSHOT, EXPLAIN})
# One picture of each scene.
STILLS = HEADLESS | {BATCH}
# Whatever is drawn to its end before it is shown.
FRAMES = STILLS | {FILM}
