"""Holds points of a sweep to the references of their bench, and keeps the errors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass

from ssdo_gl.bench.measure import (
    BenchRenderer,
    ErrorStore,
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


@dataclass(frozen=True, eq=False)
class Judging:
    """Measures the errors of a point; plain data, which workers get.

    Attributes
    ----------
    mask : ndarray of bool
        Pixels that count.
    seeds : int
        Sample patterns whose errors are averaged.
    flips : tuple of str
        FLIP metrics of every point.
    """

    base: Settings
    references: ReferenceSet
    mask: Mask
    seeds: int
    flips: tuple[str, ...]

    def __call__(self, renderer: BenchRenderer, point: Point) -> dict[str, Judged]:
        """Return the errors of `point` against every reference it can be held to, by panel."""
        by_panel = self.references.by_panel
        panels = [p for p in error_panels() if p.name in by_panel and p.judges(point)]
        renderings = render_seeds(renderer, point, self.base, self.seeds, all_aovs(panels))
        return {
            panel.name: judge(
                panel,
                renderings,
                by_panel[panel.name],
                self.mask,
                self.base.exposure or 0.0,
                self.flips,
                None if point.spp else self.references.limits[panel.name],
            )
            for panel in panels
        }

    def of_all(
        self,
        renderer: BenchRenderer,
        points: Sequence[Point],
        store: ErrorStore,
        report: Callable[[str, int, int], None],
    ) -> dict[str, dict[str, Judged]]:
        """Return the errors of all points, by key; those in `store` are not measured again."""
        stored = {point.key: store.load(point) for point in points}
        judged = {key: found for key, found in stored.items() if found is not None}
        missing = [point for point in points if point.key not in judged]
        with closing(renderer.each(self, missing)) as measured:
            for point, found in zip(missing, measured, strict=True):
                store.save(point, found)
                judged[point.key] = found
                report("errors", len(judged), len(points))
        return judged
