"""Progress of long work: bars with remaining time on a terminal, a line a stage elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rich.console import Console

from ssdo_gl.graph.render_pass import ProgressCallback

# Bars take a hundredth of a second to import, and are for terminals only.
if TYPE_CHECKING:
    from rich.progress import Progress, TaskID


class StageProgress:
    """Shows how far each stage is; does nothing without a console."""

    def __init__(self, console: Console | None, bars: Progress | None) -> None:
        self._console = console
        self._bars = bars
        self._tasks: dict[str, TaskID] = {}
        self._said: set[str] = set()
        self._start = time.perf_counter()

    def steps(self, stage: str, done: int, total: int) -> None:
        """Show that `done` of `total` steps of `stage` are done."""
        self.share(stage, stage, done / max(total, 1))

    def share(self, stage: str, text: str, share: float) -> None:
        """Show that a share of `stage`, [0, 1], is done."""
        if self._bars is not None:
            if stage not in self._tasks:
                self._tasks[stage] = self._bars.add_task(text, total=1.0)
            self._bars.update(self._tasks[stage], completed=min(share, 1.0), description=text)
        elif self._console is not None and stage not in self._said:
            self._said.add(stage)
            elapsed = time.perf_counter() - self._start
            self._console.print(f"{elapsed:6.1f} s  {stage} ...", markup=False)

    def say(self, text: str) -> None:
        """Print a line."""
        if self._console is not None:
            self._console.print(text, markup=False)


@contextmanager
def stage_progress(*, quiet: bool) -> Iterator[StageProgress]:
    """Yield a `StageProgress` on standard error."""
    if quiet:
        yield StageProgress(None, None)
        return
    # This stream, whatever takes its place while bars are drawn.
    console = Console(file=sys.stderr, highlight=False, soft_wrap=True)
    if not console.is_terminal:
        yield StageProgress(console, None)
        return
    from rich import progress as rich

    bars = rich.Progress(
        rich.TextColumn("{task.description}"),
        rich.BarColumn(),
        rich.TaskProgressColumn(),
        rich.TimeElapsedColumn(),
        rich.TimeRemainingColumn(),
        console=console,
    )
    with bars:
        yield StageProgress(console, bars)


@contextmanager
def progress_on_terminal(*, quiet: bool) -> Iterator[ProgressCallback | None]:
    """Yield a callback that draws bars on standard error, or None where it is no terminal."""
    if not sys.stderr.isatty():
        yield None
        return
    with stage_progress(quiet=quiet) as progress:
        yield None if quiet else progress.steps


@contextmanager
def waiting(text: str) -> Iterator[None]:
    """Show a bar without end and the time that passes, on standard error, a terminal."""
    from rich import progress as rich

    bars = rich.Progress(
        rich.TextColumn("{task.description}", markup=False),
        rich.BarColumn(),
        rich.TimeElapsedColumn(),
        console=Console(stderr=True, highlight=False, soft_wrap=True),
        transient=True,
    )
    with bars:
        bars.add_task(text, total=None)
        yield
