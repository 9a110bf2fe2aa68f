"""Says what was simulated, what was not and why, and what that saved."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rich.markup import escape
from rich.table import Table

from ssdo_gl.render_result import FrameTimes, RenderResult
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera

# Frames of each pipeline that are timed, turn by turn, so that both meet the same load.
# The least time of each pass counts: whatever else runs only ever adds to it.
ROUNDS = 3


@dataclass(frozen=True)
class Times:
    """What one pipeline takes when nothing else runs, milliseconds.

    Attributes
    ----------
    passes : mapping of pass name to float
        Only those that run in every frame.
    frame : float
    """

    passes: Mapping[str, float]
    frame: float


@dataclass(frozen=True)
class Explanation:
    """What the planned and the full pipeline took, side by side.

    Attributes
    ----------
    planned, full : Times or None
        None if it was not measured.
    """

    result: RenderResult
    planned: Times | None = None
    full: Times | None = None

    def saved_by_pass(self) -> dict[str, float]:
        """Return milliseconds that the plan saves on each pass; negative: it costs more."""
        if self.planned is None or self.full is None:
            return {}
        names = {**self.full.passes, **self.planned.passes}
        return {
            name: self.full.passes.get(name, 0.0) - self.planned.passes.get(name, 0.0)
            for name in names
        }

    def saved_by_decision(self) -> dict[str, float]:
        """Return milliseconds by effect; a pass counts for the first that spares it."""
        saved = self.saved_by_pass()
        result: dict[str, float] = {}
        for decision in self.result.decisions:
            if decision.run or not saved:
                continue
            names = [name for name in decision.passes + decision.instead if name in saved]
            result[decision.effect] = sum(saved.pop(name) for name in dict.fromkeys(names))
        return result


def explain(
    renderer: Renderer, result: RenderResult, camera: Camera | None = None, seconds: float = 0.0
) -> Explanation:
    """Return `result` with the times of its plan and of the full pipeline beside it.

    References are not timed again: what can be spared of them is small.

    Parameters
    ----------
    renderer : Renderer
        The one that made `result`, `camera` and `seconds` as for it.
    """
    settings = dataclasses.replace(renderer.settings, antialias=1)
    if settings.is_reference or settings.effects == "full":
        return Explanation(result)
    wanted = tuple(result.images)
    both = ("auto", "full")
    renderers = [
        Renderer(
            renderer.scene,
            dataclasses.replace(settings, effects=effects),
            device=renderer.device,
            shaders=renderer.shaders,
        )
        for effects in both
    ]
    frames: list[list[FrameTimes]] = [[], []]
    # Programs are compiled and maps are made in the first round, which does not count.
    for number in range(ROUNDS + 1):
        for chosen, taken in zip(renderers, frames, strict=True):
            times = chosen.time_frame(
                wanted, camera=camera, seconds=seconds, number=number, time_passes=True
            )
            if number > 0:
                taken.append(times)
    for chosen in renderers:
        chosen.release()
    return Explanation(result, *(_least(taken) for taken in frames))


def _least(frames: list[FrameTimes]) -> Times:
    by_name: dict[str, list[float]] = {}
    for frame in frames:
        for row in frame.passes:
            if row.ran and row.gpu_ms is not None:
                by_name.setdefault(row.name, []).append(row.gpu_ms)
    passes = {name: min(times) for name, times in by_name.items()}
    return Times(passes, min(frame.frame_ms for frame in frames))


def explanation_table(explanation: Explanation) -> Table:
    """Return what ran and what did not, why, and what that cost or saved, as a table."""
    saved, by_decision = explanation.saved_by_pass(), explanation.saved_by_decision()
    result = explanation.result
    table = Table(title="passes", title_justify="left")
    for column in ("pass", "runs", "ms", "saved", "reason"):
        number = column in ("ms", "saved")
        table.add_column(column, justify="right" if number else "left", no_wrap=column != "reason")
    for row in result.passes:
        milliseconds, reason = row.gpu_ms, row.reason
        if explanation.planned is not None:
            milliseconds = explanation.planned.passes.get(row.name)
            reason += "; kept after the first frame" if row.ran and milliseconds is None else ""
        table.add_row(*_cells(row.name, row.ran, milliseconds, saved.get(row.name), reason))
    table.add_section()
    for item in result.decisions:
        spared = by_decision.get(item.effect)
        table.add_row(*_cells(f"({item.effect})", item.run, None, spared, item.reason))
    return table


def _cells(
    name: str, runs: bool, milliseconds: float | None, saved: float | None, reason: str
) -> tuple[str, str, str, str, str]:
    taken = "" if milliseconds is None else f"{milliseconds:.2f}"
    # Differences of a twentieth of a millisecond are noise.
    spared = "" if saved is None or abs(saved) < 0.05 else f"{saved:.1f}"
    return name, "yes" if runs else "no", taken, spared, escape(reason)


def summary(explanation: Explanation) -> str | None:
    """Return one line on the whole frame; None if nothing was measured."""
    planned, full = explanation.planned, explanation.full
    if planned is None or full is None:
        return None
    part = planned.frame / full.frame
    # What runs instead of other passes could run, too.
    possible = {**planned.passes, **full.passes}
    return (
        f"{len(planned.passes)} of {len(possible)} passes,"
        f" {planned.frame:.1f} of {full.frame:.1f} ms a frame ({part:.2f} of the full pipeline)"
    )


def decisions_for_json(explanation: Explanation) -> list[dict[str, Any]]:
    """Return every decision with the milliseconds that it saved, None if not measured."""
    saved = explanation.saved_by_decision()
    return [
        {
            "effect": item.effect,
            "run": item.run,
            "reason": item.reason,
            "passes": list(item.passes),
            "saved_ms": round(saved[item.effect], 3) if item.effect in saved else None,
        }
        for item in explanation.result.decisions
    ]
