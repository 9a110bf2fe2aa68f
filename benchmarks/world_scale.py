"""Does the unit of length matter? The same scene in other units, against one reference.

A scene measured in millimetres must look like the same scene in kilometres. The paper's
bounce clamps the distance to a sender at 1 "world unit" (RGS09, section 3, unit unstated),
so its brightness depends on what the unit is; the estimators here must not.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ssdo_gl.bench.measure.bench_renderer import OpenRenderer
from ssdo_gl.bench.measure.errors import color
from ssdo_gl.bench.measure.points import Point
from ssdo_gl.bench.measure.reference_cache import Reference
from ssdo_gl.bench.report import COLORS, MARKERS, drawn_in_style
from ssdo_gl.images.error import Mask, bias, mean_level, relative_rmse
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FACTORS = (1e-3, 1e-2, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0, 1e4)
SAMPLES = 64
# Where the paper clamps the distance to a sender, in world units.
PAPER_CLAMP = 1.0


def scaled_scene(scene: Scene, factor: float) -> Scene:
    """Return `scene` with every length multiplied by `factor`, lit to look the same.

    Radiances stay; a point light's intensity grows with the square, as irradiance falls
    with the square of the distance. Motion is dropped.
    """
    objects = []
    for item in scene.objects:
        matrices = item.world_from_object.copy()
        matrices[:, :3, :] *= factor
        objects.append(dataclasses.replace(item, world_from_object=matrices, motion=None))
    return dataclasses.replace(
        scene,
        objects=tuple(objects),
        lights=tuple(
            dataclasses.replace(light.scaled(factor), motion=None) for light in scene.lights
        ),
        camera=_scaled_camera(scene.camera, factor),
        render={},
    )


def _times(vector: Sequence[float], factor: float) -> tuple[float, float, float]:
    x, y, z = vector
    return x * factor, y * factor, z * factor


def _scaled_camera(camera: Camera, factor: float) -> Camera:
    return dataclasses.replace(
        camera, position=_times(camera.position, factor), target=_times(camera.target, factor)
    )


@dataclass(frozen=True)
class ScaleCurve:
    """How one estimator's bounce fares in other units.

    Attributes
    ----------
    factors : tuple of float
        World units per unit of the original scene.
    errors : tuple of float
        RMSE of the bounce over the mean of its reference.
    levels : tuple of float
        Mean of the bounce over the mean of its reference; 1 is right.
    """

    name: str
    factors: tuple[float, ...]
    errors: tuple[float, ...]
    levels: tuple[float, ...]


def estimators(radius: float) -> dict[str, Point]:
    """Return the estimators that are compared, for a near field of `radius` world units."""
    paper = (("bounce.distance_clamp", PAPER_CLAMP / radius),)
    return {
        "rgs09 as written (distance clamped at 1 world unit)": Point(
            "radiance", "scale", "bounce", "rgs09", SAMPLES, 1, 1.0, "edge", overrides=paper
        ),
        "rgs09, clamp relative to R": Point(
            "radiance", "scale", "bounce", "rgs09", SAMPLES, 1, 1.0, "edge"
        ),
        "march (solid angle, no clamp)": Point(
            "radiance", "scale", "bounce", "march", SAMPLES, 8, 1.0, "edge"
        ),
    }


def measure_world_scale(
    scene: Scene,
    base: Settings,
    reference: Reference,
    mask: Mask,
    open_renderer: OpenRenderer,
    factors: Sequence[float] = FACTORS,
) -> list[ScaleCurve]:
    """Render `scene` in other units and hold the bounce to the reference of the original.

    Parameters
    ----------
    reference : Reference
        Of the original scene, with the image ``bounce``.
    """
    assert base.radius is not None
    target = color(reference.images["bounce"])
    variance = color(reference.variance["bounce"])
    level = mean_level(target, mask)
    errors: dict[str, list[float]] = {}
    levels: dict[str, list[float]] = {}
    for factor in factors:
        settings = dataclasses.replace(base, radius=base.radius * factor)
        with open_renderer(scaled_scene(scene, factor)) as bench_renderer:
            for name, point in estimators(base.radius * factor).items():
                image = color(
                    bench_renderer.images(point.settings(settings), ("bounce",))["bounce"]
                )
                errors.setdefault(name, []).append(relative_rmse(image, target, mask, variance))
                shift = bias(image, target, mask)
                levels.setdefault(name, []).append(1.0 + shift / level if level else math.nan)
    return [
        ScaleCurve(name, tuple(factors), tuple(errors[name]), tuple(levels[name]))
        for name in errors
    ]


def scale_figure(curves: Sequence[ScaleCurve]) -> Figure:
    """Return brightness and error of the bounce against the unit of length."""
    return drawn_in_style(_draw, curves)


def _draw(curves: Sequence[ScaleCurve]) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 4.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    for number, curve in enumerate(curves):
        style = {"color": COLORS[number], "marker": MARKERS[number], "markersize": 4}
        left.plot(curve.factors, curve.levels, label=curve.name, **style)
        right.plot(curve.factors, curve.errors, label=curve.name, **style)
    left.axhline(1.0, color="#888888", linewidth=0.8, linestyle="--")
    # Above the curves, for the legend.
    left.set_ylim(-0.05, 1.45)
    left.set_ylabel("mean bounce / its reference")
    right.set_ylabel("RMSE of the bounce / mean of its reference")
    for chart in (left, right):
        chart.set_xscale("log")
        chart.set_xlabel("length of the scene, relative to the original")
    left.legend(fontsize=7, loc="upper left", bbox_to_anchor=(0.0, 0.97))
    return figure
