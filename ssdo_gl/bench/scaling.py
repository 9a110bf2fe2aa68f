"""How cost grows: with samples, pixels, radius and triangles, by parts of the frame."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ssdo_gl.bench.bench_data import Series
from ssdo_gl.bench.measure import BenchRenderer, Point
from ssdo_gl.graph.render_pass import ProgressCallback
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment import GradientEnvironment
from ssdo_gl.scene.geometry import Mesh, SceneObject, sphere
from ssdo_gl.scene.lights import DirectionalLight
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

# Which part of the frame a pass belongs to. Passes that are not named are "rest".
PARTS = {
    "gbuffer": "G-buffer",
    "back_faces": "back faces",
    "shadow_map": "direct light",
    "translucent_shadows": "direct light",
    "direct": "direct light",
    "cached_irradiance": "far field",
    "far_probes": "far field",
    "ssao": "estimators",
    "directional": "estimators",
    "bounce": "estimators",
    "ssao_filter": "filters",
    "directional_filter": "filters",
    "bounce_filter": "filters",
    "edge_aware_filter": "filters",
    "reflections": "gloss",
    "reflections_filter": "gloss",
    "reflected_radiance": "gloss",
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
# Returns an x and milliseconds by part of the frame.
Job = Callable[[], tuple[float, dict[str, float]]]


def parts_of(split: Sequence[tuple[str, float]]) -> dict[str, float]:
    """Return milliseconds by part of the frame, and all together."""
    result = dict.fromkeys(dict.fromkeys(PARTS.values()), 0.0) | {"rest": 0.0}
    for name, milliseconds in split:
        result[PARTS.get(name, "rest")] += milliseconds
    used = {name: value for name, value in result.items() if value > 0.0}
    return used | {"whole frame": sum(result.values())}


def measure_scaling(
    renderer: BenchRenderer,
    base: Settings,
    radius_px: float,
    quick: bool,
    clock: str,
    report: ProgressCallback | None = None,
) -> list[Series]:
    """Time the default pipeline while one quantity varies.

    Parameters
    ----------
    clock : str
        One of `CLOCKS`.
    radius_px : float
        The near field's mean radius on the screen at the base's settings.
    """
    settings = TIMED_POINT.settings(base)
    assert settings.radius is not None

    def few(values: Sequence[float]) -> Sequence[float]:
        last, count = len(values) - 1, QUICK_COUNT - 1
        return [values[round(i * last / count)] for i in range(QUICK_COUNT)] if quick else values

    def frame(x: float, **changes: Any) -> Job:
        changed = dataclasses.replace(settings, **changes)
        return lambda: (x, parts_of(renderer.split(changed, WANTED, FRAMES, clock)))

    def field(count: float) -> Job:
        return lambda: _triangle_row(int(count), renderer, base, clock)

    sizes = [
        (max(1, round(base.size[0] * factor)), max(1, round(base.size[1] * factor)))
        for factor in few(SIDE_FACTORS)
    ]
    radii = few(RADIUS_FACTORS)
    jobs: dict[str, tuple[str, list[Job]]] = {
        "samples": (
            "depth reads per pixel",
            [frame(n, samples=int(n)) for n in few(SAMPLE_COUNTS)],
        ),
        "pixels": ("pixels", [frame(size[0] * size[1], size=size) for size in sizes]),
        "radius": (
            "mean radius of the near field, px",
            [frame(radius_px * f, radius=settings.radius * f) for f in radii],
        ),
        "triangles": ("triangles", [field(count) for count in few(TRIANGLE_COUNTS)]),
    }
    total, done, series = sum(len(rows) for _, rows in jobs.values()), 0, []
    for name, (label, waiting) in jobs.items():
        rows = []
        for job in waiting:
            rows.append(job())
            done += 1
            if report is not None:
                report("scaling", done, total)
        parts = dict.fromkeys(part for _, row in rows for part in row)
        curves = {part: tuple(row.get(part, math.nan) for _, row in rows) for part in parts}
        series.append(Series(name, label, tuple(float(x) for x, _ in rows), curves))
    return series


def _triangle_row(
    wanted: int, renderer: BenchRenderer, base: Settings, clock: str
) -> tuple[float, dict[str, float]]:
    """Return (triangles, milliseconds by part) of the generated field."""
    scene = sphere_field(wanted)
    near = dataclasses.replace(base, radius=0.5, overrides={})
    traced = dataclasses.replace(
        near, method="reference-ao", estimator=None, spp=REFERENCE_SPP, max_error=None
    )
    with renderer.of_scene(scene) as other:
        row = parts_of(other.split(TIMED_POINT.settings(near), WANTED, FRAMES, clock))
        split = other.split(traced, ("visibility",), 2, clock)
        rays = [ms for name, ms in split if name.startswith("reference")]
        row[f"{REFERENCE_SPP} rays a pixel"] = sum(rays) if rays else math.nan
    return float(scene.triangle_count), row


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
    return sphere(2 * rings)
