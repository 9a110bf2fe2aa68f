"""What a bench found as CSV and JSON."""

from __future__ import annotations

import dataclasses
from typing import Any

from ssdo_gl.bench.analysis import as_row
from ssdo_gl.bench.bench_data import Bench
from ssdo_gl.bench.storage import csv_bytes, json_bytes


def points_csv(bench: Bench) -> bytes:
    """Return every point with all its numbers as CSV."""
    return csv_bytes([as_row(result) for result in bench.results])


def bench_json(bench: Bench) -> bytes:
    """Return what the CSV has no place for: machine, references, series, recommendation."""
    recommended = bench.recommendation.result
    content: dict[str, Any] = {
        "scene": bench.scene,
        "title": bench.title,
        "size": list(bench.base.size),
        "radius": bench.base.radius,
        "radius_px": bench.radius_px,
        "triangles": bench.triangles,
        "quick": bench.quick,
        "seeds": bench.seeds,
        "rounds": bench.rounds,
        "frames": bench.frames,
        "clock": bench.clock,
        "drift": list(bench.drift),
        "machine": bench.machine,
        "references": {
            name: dataclasses.asdict(reference) for name, reference in bench.references.items()
        },
        "series": [dataclasses.asdict(series) for series in bench.series],
        "splits": {key: dict(split) for key, split in bench.splits.items()},
        "recommendation": {
            "key": recommended.point.key if recommended else None,
            "sentence": bench.recommendation.sentence,
        },
        "notes": list(bench.notes),
    }
    return json_bytes(content)
