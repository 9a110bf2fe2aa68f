"""Named settings that come out of measured Pareto fronts, and their derivation.

``ladder.toml`` holds the rungs of the front, from fast to accurate, with the error that
was measured and the presets' names. It is written by ``python -m ssdo_gl.bench.presets
OUTDIR...`` from the ``points.csv`` of several benches, and never by hand.
"""

from __future__ import annotations

import csv
import dataclasses
import difflib
import json
import sys
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from ssdo_gl.bench import pareto
from ssdo_gl.bench.clock import CLOCK_NAMES
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import SettingError, shown
from ssdo_gl.settings.names import estimators_of
from ssdo_gl.settings.presets import read_preset

# What a rung decides; everything else is the user's.
FIELDS = ("estimator", "samples", "steps", "resolution_scale", "filter")
NAMES = ("fast", "balanced", "fine", "reference")
# The ray-traced near field, until its standard error is one percent of the mean: about
# where an error can no longer be seen beside the reference.
REFERENCE = {"method": "reference-near", "max_error": 0.01}
# The setting whose time is the unit of the ladder: the paper's method as it was published.
BASELINE = "radiance-bounce-rgs09-n8-m1-s1-naive"
# Rungs nearer than this in time are one rung: nobody could tell them apart by the clock.
MIN_TIME_RATIO = 1.1
# A rung must be at least this much better than the one below to be worth its time.
MIN_ERROR_RATIO = 1.01


@dataclass(frozen=True)
class PresetRung:
    """One setting of the ladder.

    Attributes
    ----------
    relative_time : float
        Frame time over that of the paper's SSDO with 8 samples and naive blur; geometric
        mean over the benched scenes.
    error : float
        RMSE over the mean of the near-field reference; mean over the benched scenes.
    """

    estimator: str
    samples: int
    steps: int
    resolution_scale: float
    filter: str
    relative_time: float
    error: float

    @property
    def label(self) -> str:
        """What a person reads."""
        directions = max(1, self.samples // min(self.steps, self.samples))
        scale = "half" if self.resolution_scale == 0.5 else "full"
        count = f"{directions}x{self.steps}" if self.estimator == "march" else f"{self.samples}"
        return f"{self.estimator} {count} {scale} {self.filter}"

    def fields(self) -> dict[str, Any]:
        """Return the fields of `Settings` that this rung decides."""
        return {name: getattr(self, name) for name in FIELDS}

    def applied(self, settings: Settings) -> Settings:
        """Return `settings` at this rung."""
        return dataclasses.replace(settings, **fitting(self.fields(), settings.method)).checked()


def fitting(fields: Mapping[str, Any], method: str) -> dict[str, Any]:
    """Return `fields` without an estimator that `method` does not have."""
    known = fields.get("estimator") in estimators_of(method)
    return {name: value for name, value in fields.items() if name != "estimator" or known}


@dataclass(frozen=True)
class Ladder:
    """The measured front, from fast to accurate."""

    rungs: tuple[PresetRung, ...]
    presets: dict[str, int]
    source: dict[str, Any]


def read_ladder(text: str | None = None) -> Ladder:
    """Return the shipped ladder, or the one that `text` holds."""
    if text is None:
        text = files("ssdo_gl.bench").joinpath("ladder.toml").read_text(encoding="utf-8")
    data = tomllib.loads(text)
    rungs = tuple(PresetRung(**row) for row in data["rung"])
    return Ladder(rungs, dict(data["presets"]), dict(data["source"]))


def load_preset(name_or_file: str, method: str | None = None) -> dict[str, Any]:
    """Return the fields of `Settings` that a preset sets; flags win over them.

    Parameters
    ----------
    name_or_file : str
        ``fast``, ``balanced``, ``fine``, ``reference``, or a file that `read_preset` reads.
    method : str or None
        The method in force, if the user chose one: an estimator it lacks is left out.

    Raises
    ------
    SettingError
    """
    if name_or_file == "reference":
        return dict(REFERENCE) if method is None else {"max_error": REFERENCE["max_error"]}
    ladder = read_ladder()
    if name_or_file in ladder.presets:
        fields = ladder.rungs[ladder.presets[name_or_file]].fields()
        return fitting(fields, method or Settings().method)
    path = Path(name_or_file)
    if path.suffix != ".toml":
        near = difflib.get_close_matches(name_or_file, NAMES, n=1)
        hint = f"did you mean {near[0]}?" if near else f"choose {', '.join(NAMES)}"
        raise SettingError(f"--preset {shown(name_or_file)}: {hint} or a .toml file")
    return read_preset(path)


# ------------------------------------------------------------------------- derivation


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
    front = pareto.front([c.relative_time for c in merged], [c.error for c in merged])
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
        "#   python -m ssdo_gl.bench.presets OUTDIR...",
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


def main(folders: Sequence[str]) -> int:
    """Derive the ladder from the benches in `folders` and print it."""
    if not folders:
        print("usage: python -m ssdo_gl.bench.presets OUTDIR... > ladder.toml", file=sys.stderr)
        return 2
    tables, scenes, machine, clocks = [], [], {}, set()
    for folder in folders:
        with (Path(folder) / "points.csv").open(encoding="utf-8", newline="") as file:
            tables.append(list(csv.DictReader(file)))
        bench = json.loads((Path(folder) / "bench.json").read_text(encoding="utf-8"))
        scenes.append(f"{bench['scene']} {bench['size'][0]}x{bench['size'][1]}")
        machine = bench["machine"]
        clocks.add(CLOCK_NAMES[bench["clock"]])
    rungs, presets = derive(tables)
    source = {
        "benches": scenes,
        "renderer": machine.get("renderer", ""),
        "clock": ", ".join(sorted(clocks)),
        "version": machine.get("ssdo_gl", ""),
        "date": str(machine.get("date", ""))[:10],
    }
    print(ladder_text(rungs, presets, source), end="")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
