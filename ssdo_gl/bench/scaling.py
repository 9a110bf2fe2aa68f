"""How cost grows: with samples, pixels, radius and triangles, by parts of the frame."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ssdo_gl.bench.bench_data import Series
from ssdo_gl.bench.bench_renderer import BenchRenderer, OpenRenderer
from ssdo_gl.bench.points import Point
from ssdo_gl.graph.render_pass import ProgressCallback
from ssdo_gl.scene import shapes
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment import GradientEnvironment
from ssdo_gl.scene.lights import DirectionalLight
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.mesh import Mesh, SceneObject
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

# Which part of the frame a pass belongs to. Passes that are not named are "rest".
PARTS = {
    "gbuffer": "G-buffer",
    "back_faces": "back faces",
    "shadow_map": "direct light",
    "direct": "direct light",
    "ssao": "estimators",
    "directional": "estimators",
    "bounce": "estimators",
    "ssao_filter": "filters",
    "directional_filter": "filters",
    "bounce_filter": "filters",
}
TIMED_POINT = Point("radiance", "scaling", "bounce", "march", 64, 8, 1.0, "edge")
WANTED = ("beauty",)
SAMPLE_COUNTS = (8, 16, 32, 64, 128, 256)
# Relative to the bench's own frame, along one side.
SIDE_FACTORS = (0.25, 0.5, 1.0, 1.5, 2.0)
RADIUS_FACTORS = (0.125, 0.25, 0.5, 1.0, 2.0, 4.0)
TRIANGLE_COUNTS = (400, 4_000, 40_000, 400_000)
# The quick bench has two minutes for everything.
QUICK_COUNT = 3
FRAMES = 3
# Rays per pixel of the references whose growth with triangles is timed.
REFERENCE_SPP = 4


@dataclass(frozen=True)
class Budget:
    """How many values of each quantity are timed."""

    quick: bool

    def of(self, values: Sequence[float]) -> tuple[float, ...]:
        """Return all values, or a few spread over their range."""
        if not self.quick or len(values) <= QUICK_COUNT:
            return tuple(values)
        last = len(values) - 1
        return tuple(values[round(i * last / (QUICK_COUNT - 1))] for i in range(QUICK_COUNT))


def parts_of(split: Sequence[tuple[str, float]]) -> dict[str, float]:
    """Return milliseconds by part of the frame, and all together."""
    result = dict.fromkeys(dict.fromkeys(PARTS.values()), 0.0) | {"rest": 0.0}
    for name, milliseconds in split:
        result[PARTS.get(name, "rest")] += milliseconds
    used = {name: value for name, value in result.items() if value > 0.0}
    return used | {"whole frame": sum(result.values())}


def _series(
    name: str, x_label: str, x: Sequence[float], rows: Sequence[dict[str, float]]
) -> Series:
    """Arrange one row of parts per x as curves; a part that did not run is NaN there."""
    names = list(dict.fromkeys(part for row in rows for part in row))
    curves = {part: tuple(row.get(part, math.nan) for row in rows) for part in names}
    return Series(name, x_label, tuple(float(value) for value in x), curves)


def measure_scaling(
    renderer: BenchRenderer,
    base: Settings,
    radius_px: float,
    quick: bool,
    clock: str,
    open_renderer: OpenRenderer | None = None,
    report: ProgressCallback | None = None,
) -> list[Series]:
    """Time the default pipeline while one quantity varies.

    Parameters
    ----------
    open_renderer : callable or None
        Opens a renderer for another scene; without it triangles are left out.
    clock : str
        One of `CLOCKS`.
    radius_px : float
        The near field's mean radius on the screen at the base's settings.
    """
    budget = Budget(quick)
    settings = TIMED_POINT.settings(base)
    jobs: list[tuple[str, str, list[float], list[Settings]]] = []
    counts = budget.of(SAMPLE_COUNTS)
    jobs.append(
        (
            "samples",
            "depth reads per pixel",
            list(counts),
            [dataclasses.replace(settings, samples=int(n)) for n in counts],
        )
    )
    sizes = [_scaled(base.size, factor) for factor in budget.of(SIDE_FACTORS)]
    pixels: list[float] = [float(w * h) for w, h in sizes]
    jobs.append(
        ("pixels", "pixels", pixels, [dataclasses.replace(settings, size=s) for s in sizes])
    )
    factors = budget.of(RADIUS_FACTORS)
    assert settings.radius is not None
    radii = [settings.radius * factor for factor in factors]
    jobs.append(
        (
            "radius",
            "mean radius of the near field, px",
            [radius_px * factor for factor in factors],
            [dataclasses.replace(settings, radius=r) for r in radii],
        )
    )
    total = sum(len(values) for _, _, values, _ in jobs)
    total += len(budget.of(TRIANGLE_COUNTS)) if open_renderer else 0
    done = 0
    series = []
    for name, label, values, variants in jobs:
        rows = []
        for variant in variants:
            rows.append(parts_of(renderer.split(variant, WANTED, FRAMES, clock)))
            done += 1
            if report is not None:
                report("scaling", done, total)
        series.append(_series(name, label, values, rows))
    if open_renderer is not None:
        counts_and_rows = []
        for item in triangle_rows(open_renderer, base, budget, clock):
            counts_and_rows.append(item)
            done += 1
            if report is not None:
                report("scaling", done, total)
        triangles, parts = zip(*counts_and_rows, strict=True)
        series.append(_series("triangles", "triangles", list(triangles), list(parts)))
    return series


def triangle_rows(
    open_renderer: OpenRenderer, base: Settings, budget: Budget, clock: str
) -> Iterator[tuple[float, dict[str, float]]]:
    """Yield (triangles, milliseconds by part) of the generated field, growing."""
    for wanted in budget.of(TRIANGLE_COUNTS):
        scene = sphere_field(int(wanted))
        near = dataclasses.replace(base, radius=0.5, overrides={})
        with open_renderer(scene) as renderer:
            row = parts_of(renderer.split(TIMED_POINT.settings(near), WANTED, FRAMES, clock))
            traced = dataclasses.replace(
                near, method="reference-ao", estimator=None, spp=REFERENCE_SPP, max_error=None
            )
            split = dict(renderer.split(traced, ("visibility",), 2, clock))
            rays = [ms for name, ms in split.items() if name.startswith("reference")]
            row[f"{REFERENCE_SPP} rays a pixel"] = sum(rays) if rays else math.nan
        yield float(scene.triangle_count), row


def _scaled(size: tuple[int, int], factor: float) -> tuple[int, int]:
    return max(1, round(size[0] * factor)), max(1, round(size[1] * factor))


# The field is a square of this many spheres, so that every triangle count shows the same
# picture: only the tessellation changes.
FIELD_SIDE = 4


def sphere_field(triangle_count: int) -> Scene:
    """Return a field of spheres on a floor with about `triangle_count` triangles."""
    per_sphere = max(8, triangle_count // FIELD_SIDE**2)
    sphere = _sphere(per_sphere)
    radius, middle = 0.4, 0.5 * (FIELD_SIDE - 1)
    places = np.zeros((FIELD_SIDE**2, 4, 4))
    places[:] = np.diag((radius, radius, radius, 1.0))
    for index in range(FIELD_SIDE**2):
        row, column = divmod(index, FIELD_SIDE)
        places[index, :3, 3] = (column - middle) * 0.9, radius, (row - middle) * 0.9
    floor = Mesh(
        np.array([[-3.0, 0, -3], [-3, 0, 3], [3, 0, 3], [3, 0, -3]]),
        np.array([[0, 1, 2], [0, 2, 3]]),
        name="floor",
    )
    return Scene(
        (sphere, floor),
        (Material(albedo=(0.7, 0.5, 0.3)), Material(albedo=(0.6, 0.6, 0.6))),
        (SceneObject(0, 0, places), SceneObject(1, 1)),
        Camera((3.6, 3.2, 4.2), (0.0, 0.2, 0.0)),
        (DirectionalLight((-0.4, -0.8, -0.447), (1.5, 1.4, 1.2)),),
        GradientEnvironment((0.4, 0.55, 0.9), (0.7, 0.75, 0.8), (0.2, 0.18, 0.15)),
        title="Field of spheres",
    )


def _sphere(triangle_count: int) -> Mesh:
    """Return a unit sphere with about `triangle_count` triangles, closed."""
    # 2 n segments and n rings, less the halves at the poles: 4 n (n - 1) triangles.
    rings = max(2, round(0.5 * (1.0 + math.sqrt(1.0 + triangle_count))))
    return shapes.sphere(2 * rings)
