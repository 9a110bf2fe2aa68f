"""The measured front of error against time, and where the window stands on it. Pure.

The front was measured on other scenes and perhaps another machine: its times are
relative to one another. They are laid over this machine's by the one time that is known
of both, that of the settings in use.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ssdo_gl.settings import Settings


@dataclass(frozen=True)
class ChartPoint:
    """One setting of the front.

    Attributes
    ----------
    frame_ms : float
        What it should take here.
    error : float
        RMSE over the mean of the reference.
    is_used : bool
        Whether these are the settings in use.
    """

    label: str
    frame_ms: float
    error: float
    is_used: bool


def chart_points(
    measured: Sequence[Mapping[str, Any]], settings: Settings, frame_ms: float
) -> list[ChartPoint]:
    """Return the front in this machine's milliseconds, from fast to accurate.

    Parameters
    ----------
    measured : sequence of mapping
        ``label``, ``samples``, ``steps``, ``resolution_scale``, ``relative_time`` and
        ``error`` of each setting.
    settings : Settings
        In use.
    frame_ms : float
        What a frame takes with them.
    """
    if not measured or frame_ms <= 0.0:
        return []
    here = min(measured, key=lambda row: _distance(row, settings))
    scale = frame_ms / float(here["relative_time"])
    is_on_front = _distance(here, settings) == 0.0
    return [
        ChartPoint(
            str(row["label"]),
            scale * float(row["relative_time"]),
            float(row["error"]),
            is_on_front and row is here,
        )
        for row in measured
    ]


def log_position(value: float, low: float, high: float) -> float:
    """Return where `value` lies between `low` and `high` on a logarithmic axis, 0 to 1."""
    if not low < high:
        return 0.5
    return (math.log(max(value, 1e-12)) - math.log(low)) / (math.log(high) - math.log(low))


def _distance(row: Mapping[str, Any], settings: Settings) -> float:
    """Return how unlike a setting of the front the present ones are; 0 for the same."""
    distance = abs(math.log2(row["samples"] / settings.samples))
    distance += 2.0 * abs(math.log2(row["resolution_scale"] / settings.resolution_scale))
    return distance + 0.1 * abs(math.log2(row["steps"] / settings.steps))
