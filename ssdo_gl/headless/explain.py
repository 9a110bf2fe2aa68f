"""Says what was simulated, what was not and why, and what that saved."""

from __future__ import annotations

import dataclasses
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rich.markup import escape
from rich.table import Table

from ssdo_gl.graph.render_pass import ProgressCallback
from ssdo_gl.render_result import FrameTimes, RenderResult
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera

# Frames of each pipeline that are timed, turn by turn, so that both meet the same load.
# Were there no difference, all of seven would point the same way once in 64 times.
ROUNDS = 7


@dataclass(frozen=True)
class Times:
    """What one frame of a pipeline took, each pass waited for; milliseconds.

    Attributes
    ----------
    passes : mapping of pass name to float
        Those that ran.
    frame : float
        All of them, and what lies between them.
    """

    passes: Mapping[str, float]
    frame: float


@dataclass(frozen=True)
class Spread:
    """The median and the range of what the rounds found."""

    median: float
    low: float
    high: float

    @staticmethod
    def of(values: Sequence[float]) -> Spread:
        """Return the spread of one value per round."""
        return Spread(statistics.median(values), min(values), max(values))

    @property
    def is_saving(self) -> bool:
        """Whether every round found one, so that it is not noise."""
        return self.low > 0.0

    def __str__(self) -> str:
        return f"{self.median:.2f} [{self.low:.2f}, {self.high:.2f}]"


@dataclass(frozen=True)
class Explanation:
    """What the planned and the full pipeline took, side by side.

    Attributes
    ----------
    planned, full : sequence of Times
        One for each round, in pairs; empty if they were not measured.
    """

    result: RenderResult
    planned: Sequence[Times] = ()
    full: Sequence[Times] = ()

    def typical(self) -> Times | None:
        """Return the planned frame of median duration: its passes add up."""
        by_time = sorted(self.planned, key=lambda times: times.frame)
        return by_time[len(by_time) // 2] if by_time else None

    def saved(self, names: Sequence[str]) -> Spread:
        """Return what the plan saves on the named passes together; negative: it costs more."""
        return Spread.of(
            [
                sum(full.passes.get(n, 0.0) - planned.passes.get(n, 0.0) for n in names)
                for planned, full in zip(self.planned, self.full, strict=True)
            ]
        )

    def saved_by_pass(self) -> dict[str, Spread]:
        """Return milliseconds that the plan saves on each pass."""
        rounds = (*self.full, *self.planned)
        return {
            name: self.saved([name]) for name in dict.fromkeys(n for t in rounds for n in t.passes)
        }

    def saved_by_decision(self) -> dict[str, Spread]:
        """Return milliseconds by effect; a pass counts for the first that spares it."""
        left = set(self.saved_by_pass())
        result: dict[str, Spread] = {}
        for decision in self.result.decisions:
            names = [n for n in dict.fromkeys(decision.passes + decision.instead) if n in left]
            if not decision.run and names:
                left -= set(names)
                result[decision.effect] = self.saved(names)
        return result


def explain(
    renderer: Renderer,
    result: RenderResult,
    camera: Camera | None = None,
    seconds: float = 0.0,
    progress: ProgressCallback | None = None,
) -> Explanation:
    """Return `result` with the times of its plan and of the full pipeline beside it.

    References are not timed again: what can be spared of them is small.

    Parameters
    ----------
    renderer : Renderer
        The one that made `result`, `camera` and `seconds` as for it.
    progress : callable or None
        Hears of each round: at 1280x720 all of them take a minute or more.
    """
    settings = dataclasses.replace(renderer.settings, antialias=1)
    if settings.is_reference or settings.effects == "full":
        return Explanation(result)
    wanted = tuple(result.images)
    renderers = [
        Renderer(
            renderer.scene,
            dataclasses.replace(settings, effects=effects),
            device=renderer.device,
            shaders=renderer.shaders,
        )
        for effects in ("auto", "full")
    ]
    rounds: tuple[list[Times], list[Times]] = ([], [])
    # Programs are compiled and maps are made in the first round, which does not count.
    for number in range(ROUNDS + 1):
        if progress is not None:
            progress("plan and full pipeline timed", number, ROUNDS)
        # Each goes first in turn: whatever the one before leaves behind helps both alike.
        for index in (0, 1) if number % 2 else (1, 0):
            frame = renderers[index].time_frame(
                wanted, camera=camera, seconds=seconds, number=number, time_passes=True
            )
            if number > 0:
                rounds[index].append(_times(frame))
    for chosen in renderers:
        chosen.release()
    return Explanation(result, *rounds)


def _times(frame: FrameTimes) -> Times:
    passes = {r.name: r.gpu_ms for r in frame.passes if r.ran and r.gpu_ms is not None}
    return Times(passes, frame.frame_ms)


def explanation_table(explanation: Explanation) -> Table:
    """Return what ran and what did not, why, and what that cost or saved, as a table."""
    saved, by_decision = explanation.saved_by_pass(), explanation.saved_by_decision()
    result, typical = explanation.result, explanation.typical()
    table = Table(title="passes", title_justify="left")
    for column in ("pass", "runs", "ms", "saved ms [range]", "reason"):
        number = "ms" in column
        table.add_column(column, justify="right" if number else "left", no_wrap=column != "reason")
    for row in result.passes:
        milliseconds, reason = row.gpu_ms, row.reason
        if typical is not None:
            milliseconds = typical.passes.get(row.name)
            reason += "; kept after the first frame" if row.ran and milliseconds is None else ""
        table.add_row(*_cells(row.name, row.ran, milliseconds, saved.get(row.name), reason))
    if typical is not None:
        between = typical.frame - sum(typical.passes.values())
        table.add_row("between passes", "", f"{between:.2f}", "", "issuing commands and waiting")
        table.add_row("whole frame", "", f"{typical.frame:.2f}", "", "each pass waited for")
    table.add_section()
    for item in result.decisions:
        spared = by_decision.get(item.effect)
        table.add_row(*_cells(f"({item.effect})", item.run, None, spared, item.reason))
    return table


def _cells(
    name: str, runs: bool, milliseconds: float | None, saved: Spread | None, reason: str
) -> tuple[str, str, str, str, str]:
    taken = "" if milliseconds is None else f"{milliseconds:.2f}"
    spared = str(saved) if saved is not None and saved.is_saving else ""
    return name, "yes" if runs else "no", taken, escape(spared), escape(reason)


def summary(explanation: Explanation) -> str | None:
    """Return one line on the whole frame; None if nothing was measured."""
    if not explanation.planned:
        return None
    rows = explanation.result.passes
    names = {row.name for row in rows}.union(*(times.passes for times in explanation.full))
    pairs = list(zip(explanation.planned, explanation.full, strict=True))
    planned = statistics.median(times.frame for times in explanation.planned)
    full = statistics.median(times.frame for times in explanation.full)
    part = Spread.of([one.frame / other.frame for one, other in pairs])
    verdict = f"{part} of the full pipeline's"
    if part.low <= 1.0 <= part.high:
        verdict = "no difference that could be told from noise"
    return (
        f"{sum(row.ran for row in rows)} of {len(names)} passes ran;"
        f" {planned:.1f} ms a frame, {full:.1f} with all of them: {verdict}"
    )


def decisions_for_json(explanation: Explanation) -> list[dict[str, Any]]:
    """Return every decision and what it saved.

    ``saved_ms`` is None where nothing was measured or saved beyond the noise;
    ``saved_ms_range`` holds what the rounds found, None if there were none.
    """
    saved = explanation.saved_by_decision()
    rows = []
    for item in explanation.result.decisions:
        spread = saved.get(item.effect)
        rows.append(
            {
                "effect": item.effect,
                "run": item.run,
                "reason": item.reason,
                "passes": list(item.passes),
                "saved_ms": round(spread.median, 3) if spread and spread.is_saving else None,
                "saved_ms_range": [round(spread.low, 3), round(spread.high, 3)] if spread else None,
            }
        )
    return rows
