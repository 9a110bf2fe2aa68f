"""Holds points of a sweep to the references of their bench, and keeps the errors."""

from __future__ import annotations

from ssdo_gl.bench.measure import (
    BenchRenderer,
    Judged,
    Point,
    all_aovs,
    error_panels,
    judge,
    render_seeds,
)
from ssdo_gl.bench.references import ReferenceSet
from ssdo_gl.images.error import Mask
from ssdo_gl.settings import Settings


def errors_of(
    renderer: BenchRenderer,
    point: Point,
    base: Settings,
    references: ReferenceSet,
    mask: Mask,
    seeds: int,
) -> dict[str, Judged]:
    """Return the errors of `point` against every reference it can be held to, by panel.

    Parameters
    ----------
    mask : ndarray of bool
        Pixels that count.
    seeds : int
        Sample patterns whose errors are averaged.
    """
    by_panel = references.by_panel
    panels = [p for p in error_panels() if p.name in by_panel and p.judges(point)]
    renderings = render_seeds(renderer, point, base, seeds, all_aovs(panels))
    return {
        panel.name: judge(
            panel,
            renderings,
            by_panel[panel.name],
            mask,
            base.exposure or 0.0,
            None if point.spp else references.limits[panel.name],
            with_flip=True,
        )
        for panel in panels
    }
