"""Writes what a bench found: CSV, JSON, plots, report; and prints the short version."""

from __future__ import annotations

import importlib.util
from pathlib import Path

from rich.console import Console
from rich.markup import escape

from ssdo_gl.bench.bench_data import Bench
from ssdo_gl.bench.report import plots
from ssdo_gl.bench.report.data_files import bench_json, points_csv
from ssdo_gl.bench.report.page import report_html
from ssdo_gl.bench.report.terminal import print_summary
from ssdo_gl.bench.statistics import missing
from ssdo_gl.bench.storage import replace_file

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


def write_report(bench: Bench, outdir: Path) -> None:
    """Write points.csv, bench.json, pareto.png, pareto.svg and report.html."""
    replace_file(outdir / "points.csv", points_csv(bench))
    replace_file(outdir / "bench.json", bench_json(bench))
    figure = plots.pareto_figure(bench)
    for kind in ("png", "svg"):
        replace_file(outdir / f"pareto.{kind}", plots.as_bytes(figure, kind))
    replace_file(outdir / "report.html", report_html(bench).encode())


def print_outcome(bench: Bench, outdir: Path, console: Console) -> None:
    """Print the short version and where the long one is."""
    print_summary(bench, console)
    console.print(escape(f"report: {outdir / 'report.html'}"))
