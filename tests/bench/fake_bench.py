"""A bench that was never measured: plausible numbers for tests of tables, plots, report."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from image_bytes import plain_png

from ssdo_gl.bench import analysis
from ssdo_gl.bench.analysis import ReferenceSummary, Result
from ssdo_gl.bench.bench_data import Bench, Picture, Series
from ssdo_gl.bench.measure import points
from ssdo_gl.bench.measure.errors import Judged, Scalars
from ssdo_gl.bench.measure.panels import error_panels
from ssdo_gl.bench.measure.points import Point
from ssdo_gl.bench.measure.sweep import TimeTable
from ssdo_gl.bench.statistics.bootstrap import BlockErrors
from ssdo_gl.settings import Settings
from ssdo_gl.settings.loading import LoadOptions

MACHINE: dict[str, Any] = {
    "renderer": "fake <device> & driver",
    "opengl": "3.3 core",
    "backend": "egl",
    "software": True,
    "timer": "finish_wall",
    "processor": "fake processor",
    "cores": 2,
    "load": 0.25,
    "system": "Linux",
    "python": "3.11",
    "ssdo_gl": "1.0",
    "versions": {"numpy": "2.0"},
    "command": 'ssdo-gl "a <b>.toml" --bench out',
    "date": "2026-01-01",
}


def cost_ms(point: Point) -> float:
    """Return what a point is fake to cost."""
    scale = point.resolution_scale**2
    return 4.0 + 0.2 * point.samples * scale + (3.0 if point.filter == "naive" else 1.0)


def blocks(point: Point, panel: str, rng: np.random.Generator) -> tuple[BlockErrors, Scalars]:
    """Return fake errors: noise that falls with samples on top of a floor."""
    floor = 0.1 if point.estimator in ("rgs09", "hemisphere", "zbuffer", None) else 0.04
    floor += 0.2 if panel == "gi" else 0.0
    noise = 0.2 / np.sqrt(point.samples) * (0.2 if point.filter != "none" else 1.0)
    mean_square = (floor**2 + noise**2) * rng.gamma(6.0, 1 / 6.0, (2, 80))
    pixels = np.full(80, 100.0)
    errors = BlockErrors(
        mean_square * 100.0, 0.3 * floor * np.ones((2, 80)) * 100.0, 0.5 * pixels, pixels
    )
    extra = {"rel_mse": 0.1 * floor, "ssim": 0.9, "flip_ldr": 0.05, "flip_hdr": 0.07}
    parts = {"directional": floor, "bounce": 2 * floor} if panel == "near" else {}
    return errors, Scalars(noise, floor, **extra, parts=parts)


def results(quick: bool = True) -> list[Result]:
    rng = np.random.default_rng(0)
    grid = [p for p in points.read_grid() if p.quick or not quick]
    times = np.array([[cost_ms(p) * rng.uniform(0.97, 1.03) for _ in range(5)] for p in grid])
    table = TimeTable(times, times, 2 * times, np.ones(5), 50 + times[:, 0])
    judged = {
        p.key: {
            panel.name: Judged(*blocks(p, panel.name, rng))
            for panel in error_panels()
            if panel.judges(p)
        }
        for p in grid
    }
    return analysis.analyse(grid, table, judged, replicas=100)


def png(color: tuple[int, int, int]) -> bytes:
    return plain_png(color, (64, 36))


def pictures() -> list[Picture]:
    return [
        Picture("reference </script> & near", png((200, 180, 160)), None, "radiance", True, "rays"),
        Picture("bounce march 8x8 full edge", png((190, 170, 160)), png((20, 0, 40)), "radiance",
                False, "12 ms"),
        Picture("ray-traced visibility", png((240, 240, 240)), None, "visibility", True, "rays"),
        Picture("ssao march 8x8 half edge", png((230, 230, 230)), png((9, 0, 9)), "visibility",
                False, "5 ms"),
    ]  # fmt: skip


def bench(**changes: Any) -> Bench:
    """Return the fake bench, with `changes`."""
    found = results()
    references = {
        panel.name: ReferenceSummary(panel.name, panel.method, 4096, 16, 60.0, 0.004, 0.05, 0.045)
        for panel in error_panels()
    }
    series = [
        Series("samples", "depth reads per pixel", (8.0, 16.0, 32.0, 64.0),
               {"estimators": (2.0, 4.1, 8.0, 16.2), "g-buffer": (1.0, 1.0, 1.1, 1.0)}),
        Series("triangles", "triangles", (400.0, 4e3, 4e4, 4e5),
               {"estimators": (8.0, 8.1, 8.0, 8.2), "g-buffer": (1.7, 2.3, 9.0, 55.0)}),
    ]  # fmt: skip
    splits = {
        r.point.key: (("gbuffer", 1.2), ("bounce", 5.0), ("bounce_filter", 1.0)) for r in found
    }
    whole = Bench(
        scene="a <b>.toml",
        title="A <room> & more",
        scene_settings={"radius": 0.5},
        camera=None,
        loading=LoadOptions(up="z"),
        base=Settings(size=(320, 180), radius=0.3),
        radius_px=40.0,
        triangles=1234,
        quick=True,
        seeds=2,
        rounds=5,
        frames=3,
        clock="wall",
        drift=(1.0, 1.02, 0.99, 1.3, 1.0),
        machine=MACHINE,
        results=found,
        references=references,
        recommendation=analysis.recommend(found),
        series=series,
        splits=splits,
        pictures=pictures(),
        notes=("a note with <angle> brackets",),
    )
    return dataclasses.replace(whole, **changes)
