"""Measures how wrong each point of a sweep is, against every reference it can be held to."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.bench.measure.bench_renderer import BenchRenderer, Images, images_of_seed
from ssdo_gl.bench.measure.panels import ErrorPanel
from ssdo_gl.bench.measure.points import Point
from ssdo_gl.bench.measure.reference_cache import Reference
from ssdo_gl.bench.statistics import BlockErrors, decompose, flip_hdr, flip_ldr, srgb_of, ssim
from ssdo_gl.bench.storage import load_arrays, save_arrays
from ssdo_gl.images.error import Mask, mean_level, relative_mse, relative_rmse
from ssdo_gl.settings import Settings

# Raised whenever the content of a stored measurement changes.
ERROR_FORMAT = 3
_BLOCK_ARRAYS = ("squared", "signed", "reference", "pixels")


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
    rel_mse, ssim, flip_ldr, flip_hdr : float
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
    flip_hdr: float = math.nan
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
    flips: Sequence[str] = (),
    limit: Reference | None = None,
) -> Judged:
    """Hold renderings of one point (one per seed) to the reference of `panel`.

    `flips` names the FLIP metrics that are wanted: ``ldr``, ``hdr``; `limit` is the
    converged march.
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
        extra = picture_metrics(images[0], target, variance, mask, exposure_ev, flips)
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
    flips: Sequence[str],
) -> dict[str, float]:
    """Return relMSE, SSIM and the FLIP means that are wanted of a picture."""
    gain = np.float32(2.0**exposure_ev)
    shown, wanted = srgb_of(image, exposure_ev), srgb_of(reference, exposure_ev)
    result = {
        "rel_mse": relative_mse(image * gain, reference * gain, mask, variance * gain**2),
        "ssim": ssim(shown, wanted, mask),
    }
    if "ldr" in flips:
        result["flip_ldr"] = flip_ldr(shown, wanted, mask).mean
    if "hdr" in flips:
        result["flip_hdr"] = flip_hdr(image, reference, mask, exposure_ev).mean
    return result


def render_seeds(
    renderer: BenchRenderer, point: Point, base: Settings, seeds: int, wanted: Sequence[str]
) -> list[Images]:
    """Return the images of `point` for each of `seeds` seeds."""
    settings = point.settings(base)
    measure = partial(images_of_seed, settings=settings, wanted=wanted)
    return list(renderer.each(measure, range(base.seed, base.seed + seeds), chunk=1))


class ErrorStore:
    """Measurements on disk, one file a point, so that a sweep can be resumed.

    Parameters
    ----------
    key : str
        Identifies scene, settings and references; files of another key do not count.
    """

    def __init__(self, folder: Path, key: str) -> None:
        self.folder = folder
        self.key = key
        folder.mkdir(parents=True, exist_ok=True)

    def path(self, point: Point) -> Path:
        """Return the file of `point`."""
        return self.folder / f"{point.key}.npz"

    def save(self, point: Point, judged: Mapping[str, Judged]) -> None:
        """Write the measurements of `point`, by panel name."""
        arrays: dict[str, NDArray[np.float64]] = {}
        meta: dict[str, Any] = {"key": self.key, "format": ERROR_FORMAT, "panels": {}}
        for name, item in judged.items():
            meta["panels"][name] = dataclasses.asdict(item.scalars)
            for part in _BLOCK_ARRAYS:
                arrays[f"{name}:{part}"] = getattr(item.blocks, part)
        save_arrays(self.path(point), meta, arrays)

    def load(self, point: Point) -> dict[str, Judged] | None:
        """Return the measurements of `point`; None if there are none that count."""
        found = load_arrays(self.path(point))
        if found is None:
            return None
        meta, arrays = found
        if meta.get("key") != self.key or meta.get("format") != ERROR_FORMAT:
            return None
        return {
            name: Judged(
                BlockErrors(
                    **{part: arrays[f"{name}:{part}"] for part in _BLOCK_ARRAYS},
                    failures=scalars["failures"],
                ),
                Scalars(**scalars),
            )
            for name, scalars in meta["panels"].items()
        }
