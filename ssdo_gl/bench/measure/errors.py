"""Measures how wrong each point of a sweep is, against every reference it can be held to."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.bench.measure.bench_renderer import BenchRenderer, Images
from ssdo_gl.bench.measure.panels import ErrorPanel
from ssdo_gl.bench.measure.points import Point
from ssdo_gl.bench.measure.reference_cache import Reference
from ssdo_gl.bench.statistics import BlockErrors, decompose, flip_ldr, srgb_of, ssim
from ssdo_gl.images.error import Mask, mean_level, relative_mse, relative_rmse
from ssdo_gl.settings import Settings


@dataclass(frozen=True)
class Scalars:
    """What one point loses against one reference, in single numbers.

    Attributes
    ----------
    noise, systematic : float
        Root mean squares: the estimator against its own expectation (over seeds), and
        its expectation against the reference; in the panel's unit.
    own_bias : float
        The expectation against that of the converged march, which has seen all that the
        screen shows: what better settings would mend. NaN for rays.
    rel_mse, ssim, flip_ldr : float
        Of the first seed, exposed; NaN where not measured.
    parts : dict of str to float
        Error of further AOVs (relative RMSE).
    failures : int
        Pixels with NaN or infinity.
    """

    noise: float = math.nan
    systematic: float = math.nan
    own_bias: float = math.nan
    rel_mse: float = math.nan
    ssim: float = math.nan
    flip_ldr: float = math.nan
    parts: dict[str, float] = field(default_factory=dict)
    failures: int = 0


@dataclass(frozen=True, eq=False)
class Judged:
    """One point against one reference."""

    blocks: BlockErrors
    scalars: Scalars


def color(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the image without a coverage channel."""
    return image[:, :, :3] if image.shape[2] == 4 else image


def judged_pixels(renderer: BenchRenderer, settings: Settings) -> Mask:
    """Return which pixels count: covered ones that do not themselves emit light.

    Background and emitters are the same in every method; they would only dilute the
    error.
    """
    plain = dataclasses.replace(settings, method="direct", estimator=None)
    images = renderer.images(plain, ("depth", "emission"))
    covered = images["depth"][:, :, 0] > 0.0
    dark = ~np.any(images["emission"] > 0.0, axis=2)
    return np.asarray(covered & dark)


def unit_px(renderer: BenchRenderer, settings: Settings, mask: Mask) -> float:
    """Return how many pixels a length of 1 covers, averaged over the pixels of `mask`."""
    plain = dataclasses.replace(settings, method="direct", estimator=None)
    depth = renderer.images(plain, ("depth",))["depth"][:, :, 0][mask].astype(np.float64)
    width, height = settings.size
    camera = renderer.scene.camera
    tangent, half = (f(width / height)[1] for f in (camera.tan_half_fov, camera.half_frame))
    return float(np.mean(height / (2.0 * (half + tangent * depth))))


def judge(
    panel: ErrorPanel,
    renderings: Sequence[Images],
    reference: Reference,
    mask: Mask,
    exposure_ev: float,
    limit: Reference | None = None,
    *,
    with_flip: bool = False,
) -> Judged:
    """Hold renderings of one point (one per seed) to the reference of `panel`.

    `limit` is the converged march.
    """
    name = panel.aov
    images = [color(rendering[name]) for rendering in renderings]
    target, variance = color(reference.images[name]), color(reference.variance[name])
    blocks = BlockErrors.of_images(list(images), target, mask, variance)
    split = decompose(list(images), target, mask, variance)
    level = mean_level(target, mask)
    unit = level if panel.relative and level > 0.0 else 1.0
    parts = {
        part: relative_rmse(
            color(renderings[0][part]),
            color(reference.images[part]),
            mask,
            color(reference.variance[part]),
        )
        for part in panel.parts
    }
    extra: dict[str, float] = {}
    if panel.is_picture:
        extra = picture_metrics(images[0], target, variance, mask, exposure_ev, with_flip)
    own_bias = math.nan
    if limit is not None:
        own_bias = decompose(
            list(images), color(limit.images[name]), mask, color(limit.variance[name])
        ).bias
    scalars = Scalars(
        noise=split.noise / unit,
        systematic=split.bias / unit,
        own_bias=own_bias / unit,
        parts=parts,
        failures=blocks.failures,
        **extra,
    )
    return Judged(blocks, scalars)


def picture_metrics(
    image: NDArray[np.float32],
    reference: NDArray[np.float32],
    variance: NDArray[np.float32],
    mask: Mask,
    exposure_ev: float,
    with_flip: bool,
) -> dict[str, float]:
    """Return relMSE, SSIM and, if it is wanted, the mean FLIP of a picture."""
    gain = np.float32(2.0**exposure_ev)
    shown, wanted = srgb_of(image, exposure_ev), srgb_of(reference, exposure_ev)
    result = {
        "rel_mse": relative_mse(image * gain, reference * gain, mask, variance * gain**2),
        "ssim": ssim(shown, wanted, mask),
    }
    if with_flip:
        result["flip_ldr"] = flip_ldr(shown, wanted, mask).mean
    return result


def render_seeds(
    renderer: BenchRenderer, point: Point, base: Settings, seeds: int, wanted: Sequence[str]
) -> list[Images]:
    """Return the images of `point` for each of `seeds` seeds."""
    settings = point.settings(base)
    return [
        renderer.images(dataclasses.replace(settings, seed=base.seed + number), wanted)
        for number in range(seeds)
    ]
