"""Derives the presets' ladder from what `benchmarks.rungs` measures."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ssdo_gl.bench.presets import PresetRung
from ssdo_gl.bench.statistics import pareto

# The setting whose time is the unit of the ladder: the paper's method as it was published.
BASELINE = "radiance-bounce-rgs09-n8-m1-s1-naive"
# Rungs nearer than this in time are one rung: nobody could tell them apart by the clock.
MIN_TIME_RATIO = 1.1
# A rung must be at least this much better than the one below to be worth its time.
MIN_ERROR_RATIO = 1.01


@dataclass(frozen=True)
class _Candidate:
    fields: dict[str, Any]
    relative_time: float
    error: float


def derive(
    tables: Sequence[Sequence[Mapping[str, str]]],
) -> tuple[list[PresetRung], dict[str, int]]:
    """Return the ladder and its presets from the points of several benches.

    Parameters
    ----------
    tables : sequence of (sequence of mapping)
        The rows of ``points.csv`` of each bench.

    Returns
    -------
    rungs : list of PresetRung
        The front of mean error against geometric mean relative time, thinned.
    presets : dict of str to int
        ``fast``: the first rung; ``fine``: the last; ``balanced``: the most
        efficient between them.

    Raises
    ------
    ValueError
        If a bench lacks the baseline or nothing was measured by all of them.
    """
    merged = _merged(tables)
    front = pareto.pareto_front([c.relative_time for c in merged], [c.error for c in merged])
    kept: list[_Candidate] = []
    # Where the present group of rungs that the clock cannot tell apart begins.
    begins = 0.0
    for index in front:
        candidate = merged[int(index)]
        if kept and kept[-1].error < MIN_ERROR_RATIO * candidate.error:
            continue
        if kept and candidate.relative_time < MIN_TIME_RATIO * begins:
            # Practically as fast and better: it stands for the group.
            kept[-1] = candidate
            continue
        kept.append(candidate)
        begins = candidate.relative_time
    rungs = [
        PresetRung(**c.fields, relative_time=round(c.relative_time, 3), error=round(c.error, 4))
        for c in kept
    ]
    presets = {"fast": 0, "balanced": most_efficient(rungs), "fine": len(rungs) - 1}
    return rungs, presets


def _merged(tables: Sequence[Sequence[Mapping[str, str]]]) -> list[_Candidate]:
    """Return what all benches measured, averaged over them."""
    benches: list[tuple[float, dict[str, Mapping[str, str]]]] = []
    for table in tables:
        by_key = {row["key"]: row for row in table}
        if BASELINE not in by_key:
            raise ValueError(f"a bench lacks the baseline {BASELINE}")
        benches.append((float(by_key[BASELINE]["ms"]), by_key))
    shared = [
        key
        for key, row in benches[0][1].items()
        if row["method"] == "bounce"
        and float(row["radius_factor"]) == 1.0
        and row["filter"] != "none"
        and all(key in by_key and by_key[key]["near_error"] for _, by_key in benches)
    ]
    if not shared:
        raise ValueError("no setting was measured by all benches")
    return [_averaged([(unit, by_key[key]) for unit, by_key in benches]) for key in shared]


def _averaged(rows: Sequence[tuple[float, Mapping[str, str]]]) -> _Candidate:
    """Return one setting's means over benches, from (unit of time, row) of each."""
    first = rows[0][1]
    fields = {
        "estimator": first["estimator"],
        "samples": int(first["samples"]),
        "steps": int(first["steps"]),
        "resolution_scale": float(first["resolution_scale"]),
        "filter": first["filter"],
    }
    times = [float(row["ms"]) / unit for unit, row in rows]
    errors = [float(row["near_error"]) for _, row in rows]
    return _Candidate(fields, float(np.exp(np.mean(np.log(times)))), float(np.mean(errors)))


def most_efficient(rungs: Sequence[PresetRung]) -> int:
    """Return the inner rung with the largest 1 / (time x error^2).

    The ends have names of their own. With fewer than three rungs it is the first.
    """
    inner = range(1, len(rungs) - 1)
    return min(inner, key=lambda i: rungs[i].relative_time * rungs[i].error ** 2, default=0)


def ladder_text(
    rungs: Sequence[PresetRung], presets: Mapping[str, int], source: Mapping[str, Any]
) -> str:
    """Return the content of ``ladder.toml``."""
    lines = [
        "# The measured front of error against time, from fast to accurate. Written by",
        "#   make bench-presets",
        "# from benches of the scenes named below. relative_time: 1 is the paper's SSDO with",
        "# 8 samples and a naive blur; error: RMSE / mean of the near-field reference.",
        "",
        "[source]",
        *(f"{key} = {json.dumps(value)}" for key, value in source.items()),
        "",
        "[presets]",
        *(f"{name} = {index}" for name, index in presets.items()),
    ]
    for rung in rungs:
        lines += ["", "[[rung]]"]
        lines += [
            f"{name} = {json.dumps(value)}" for name, value in dataclasses.asdict(rung).items()
        ]
    return "\n".join(lines) + "\n"
