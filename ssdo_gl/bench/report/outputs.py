"""Writes what a bench found: CSV, JSON, plots, report; and prints the short version."""

from __future__ import annotations

import csv
import dataclasses
import importlib.util
import io
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape

from ssdo_gl.bench.analysis import as_row
from ssdo_gl.bench.bench_data import Bench
from ssdo_gl.bench.metrics import missing
from ssdo_gl.bench.report import plots
from ssdo_gl.bench.report.page import report_html
from ssdo_gl.bench.report.terminal import print_summary
from ssdo_gl.bench.storage import replace_file, replace_json

# Import name -> what pip calls it.
LIBRARIES = {
    "matplotlib": "matplotlib",
    "skimage": "scikit-image",
    "flip_evaluator": "flip-evaluator",
}


def check_libraries() -> None:
    """Raise MissingLibraryError before any work if a library of the bench is missing."""
    for module, name in LIBRARIES.items():
        if importlib.util.find_spec(module) is None:
            raise missing(name)


def points_csv(bench: Bench) -> bytes:
    """Return every point with all its numbers as CSV."""
    rows = [as_row(result) for result in bench.results]
    buffer = io.StringIO()
    writer = csv.DictWriter(buffer, list(rows[0]) if rows else ["key"], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return buffer.getvalue().encode()


def bench_json(bench: Bench) -> dict[str, Any]:
    """Return what the CSV has no place for: machine, references, series, recommendation."""
    recommended = bench.recommendation.result
    return {
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


def write_report(bench: Bench, outdir: Path) -> None:
    """Write points.csv, bench.json, pareto.png, pareto.svg and report.html."""
    replace_file(outdir / "points.csv", points_csv(bench))
    replace_json(outdir / "bench.json", bench_json(bench))
    figure = plots.pareto_figure(bench)
    for kind in ("png", "svg"):
        replace_file(outdir / f"pareto.{kind}", plots.as_bytes(figure, kind))
    replace_file(outdir / "report.html", report_html(bench).encode())


def print_outcome(bench: Bench, outdir: Path, console: Console) -> None:
    """Print the short version and where the long one is."""
    print_summary(bench, console)
    console.print(escape(f"report: {outdir / 'report.html'}"))
