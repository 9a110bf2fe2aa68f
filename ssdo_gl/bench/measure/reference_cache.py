"""Ray-traced references: rendered in batches until they are good enough, kept on disk.

Every batch uses another seed, so batches are independent estimates of the same image:
their mean is the reference, and their scatter says how far that mean can be trusted, without
believing what the reference says of itself.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.bench.measure.bench_renderer import BenchRenderer, images_of_seed
from ssdo_gl.bench.measure.fingerprints import fingerprint, scene_fingerprint, shader_fingerprint
from ssdo_gl.bench.storage import (
    BenchError,
    load_arrays,
    save_arrays,
    say_not_kept,
    usual_folder,
)
from ssdo_gl.images.error import Mask, mean_level, relative, root
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

# Raised whenever the meaning of a cached reference changes.
REFERENCE_FORMAT = 2
# Far from the seeds that a user or a sweep takes, so that no reference shares its samples
# with what it judges.
FIRST_SEED = 1_000_003
# A variance needs two.
MIN_BATCHES = 2
MAX_BATCHES = 1_000_000
# Settings that change what a reference converges to.
_RELEVANT = ("method", "size", "spp", "shadows", "combine", "effects", "overrides")
_RELEVANT_NEAR = ("radius",)
_RELEVANT_GI = ("bounces",)


@dataclass
class Accumulator:
    """Mean and variance of images that arrive one batch at a time (Welford)."""

    count: int = 0
    mean: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    scatter: dict[str, NDArray[np.float64]] = field(default_factory=dict)

    def add(self, images: Mapping[str, NDArray[Any]]) -> None:
        """Add one independent estimate of every image.

        Raises
        ------
        ValueError
            If a reference is not finite: nothing can be measured against it.
        """
        self.count += 1
        for name, image in images.items():
            value = image.astype(np.float64)
            if not np.isfinite(value).all():
                raise ValueError(f"the reference image {name!r} holds NaN or infinity")
            if name not in self.mean:
                self.mean[name] = np.zeros_like(value)
                self.scatter[name] = np.zeros_like(value)
            step = value - self.mean[name]
            self.mean[name] += step / self.count
            self.scatter[name] += step * (value - self.mean[name])

    def reference(self, spp: int, seconds: float) -> Reference:
        """Return the mean so far with its variance; infinite with a single batch."""
        pairs = self.count * (self.count - 1)
        variance = {
            name: (scatter / pairs if pairs else np.full_like(scatter, np.inf))
            for name, scatter in self.scatter.items()
        }
        return Reference(
            {name: mean.astype(np.float32) for name, mean in self.mean.items()},
            {name: value.astype(np.float32) for name, value in variance.items()},
            self.count,
            spp,
            seconds,
        )


@dataclass(frozen=True, eq=False)
class Reference:
    """A reference and how sure it is.

    Attributes
    ----------
    images : dict of str to ndarray (height, width, channels), float32
    variance : dict of str to ndarray
        Per-pixel variance of `images`, which are means.
    batches : int
        Independent renderings that were averaged.
    spp : int
        Rays or paths per pixel, all batches together.
    seconds : float
        What it took to render.
    """

    images: dict[str, NDArray[np.float32]]
    variance: dict[str, NDArray[np.float32]]
    batches: int
    spp: int
    seconds: float

    def standard_error(self, name: str, mask: Mask) -> float:
        """Return the root mean square standard error of a pixel over `mask`."""
        return root(mean_level(self.variance[name], mask))

    def relative_standard_error(self, name: str, mask: Mask) -> float:
        """Return `standard_error` over the image's mean; infinite for noise on black."""
        return relative(self.standard_error(name, mask), mean_level(self.images[name], mask))


@dataclass(frozen=True)
class Goal:
    """When a reference is good enough.

    Attributes
    ----------
    name : str
        The image that is judged.
    standard_error : float
        Rendering stops when the image's standard error is not above it.
    relative : bool
        Whether it is relative to the image's mean.
    max_seconds : float
        Rendering stops after this, reached or not.
    """

    name: str
    standard_error: float
    relative: bool
    max_seconds: float

    def reached(self, reference: Reference, mask: Mask) -> bool:
        """Whether `reference` meets the goal."""
        return reference.batches >= MIN_BATCHES and self.now(reference, mask) <= self.standard_error

    def now(self, reference: Reference, mask: Mask) -> float:
        """Return the standard error that the goal is about."""
        of = reference.relative_standard_error if self.relative else reference.standard_error
        return of(self.name, mask)


def reference_key(scene: Scene, settings: Settings, device_name: str, images: Sequence[str]) -> str:
    """Return the name under which a reference is cached.

    It changes with everything that changes what the reference converges to: the scene's
    geometry, materials, lights and camera, the relevant settings, the reference shaders
    and the renderer (its rasterization decides what each pixel sees). References that hold
    other `images`, or batches of another number of samples, are other references.
    """
    own = _RELEVANT_GI if settings.method == "reference-gi" else _RELEVANT_NEAR
    relevant = {name: getattr(settings, name) for name in (*_RELEVANT, *own)}
    shaders = shader_fingerprint(("reference", "gbuffer", "traced"))
    return fingerprint(
        REFERENCE_FORMAT, scene_fingerprint(scene), relevant, shaders, device_name, *sorted(images)
    )


class ReferenceCache:
    """References on disk, one file each; extended in place when more is asked for.

    Attributes
    ----------
    folder : Path or None
        None where it cannot be written, which is said once: references then last as long
        as this object.
    """

    def __init__(self, folder: Path | None = None) -> None:
        self.folder = folder or usual_folder("reference", "references")
        self._held: dict[str, tuple[Accumulator, dict[str, Any]]] = {}

    def load(self, key: str) -> tuple[Accumulator, dict[str, Any]]:
        """Return what is known of `key`; a damaged file counts as nothing."""
        if key in self._held:
            return self._held[key]
        found = None if self.folder is None else load_arrays(self.folder / f"{key}.npz")
        if found is None:
            return Accumulator(), {"spp": 0, "seconds": 0.0}
        meta, arrays = found
        kept = Accumulator(int(meta["count"]))
        for name in meta["names"]:
            kept.mean[name] = arrays[f"mean:{name}"].astype(np.float64)
            kept.scatter[name] = arrays[f"scatter:{name}"].astype(np.float64)
        return kept, meta

    def save(self, key: str, kept: Accumulator, meta: Mapping[str, Any]) -> None:
        """Write what is known of `key`."""
        if self.folder is None:
            self._held[key] = kept, dict(meta)
            return
        arrays: dict[str, NDArray[Any]] = {}
        for name in kept.mean:
            # float32 halves the file; the scatter needs no more than a few digits, and
            # the mean's rounding (6e-8) is far below any standard error reached here.
            arrays[f"mean:{name}"] = kept.mean[name].astype(np.float32)
            arrays[f"scatter:{name}"] = kept.scatter[name].astype(np.float32)
        stored = {**meta, "count": kept.count, "names": list(kept.mean)}
        try:
            save_arrays(self.folder / f"{key}.npz", stored, arrays)
        except BenchError as error:
            say_not_kept("references", error)
            self.folder = None
            self._held[key] = kept, dict(meta)


def obtain(
    renderer: BenchRenderer,
    settings: Settings,
    aovs: Sequence[str],
    goal: Goal,
    mask: Mask,
    cache: ReferenceCache,
    report: Callable[[str, float], None] | None = None,
) -> Reference:
    """Return a reference, rendering batches until the goal is reached; cached ones count.

    Parameters
    ----------
    settings : Settings
        With a ray-traced method; ``spp`` is that of one batch.
    report : callable or None
        Called with a sentence and the share of the work that is done, [0, 1].
    """
    traced = dataclasses.replace(settings, estimator=None, antialias=1, max_error=None)
    key = reference_key(renderer.scene, traced, renderer.device_name, aovs)
    kept, meta = cache.load(key)
    spent, start = float(meta["seconds"]), time.perf_counter()
    spp = int(meta["spp"])
    reference = kept.reference(spp, spent)
    seeds = range(FIRST_SEED + kept.count, FIRST_SEED + MAX_BATCHES)
    measure = partial(images_of_seed, settings=traced, wanted=aovs)
    with closing(renderer.each(measure, seeds, chunk=1)) as batches:
        while not goal.reached(reference, mask):
            elapsed = time.perf_counter() - start
            if kept.count >= MIN_BATCHES and elapsed >= goal.max_seconds:
                break
            kept.add(next(batches))
            spp += traced.spp
            elapsed = time.perf_counter() - start
            reference = kept.reference(spp, spent + elapsed)
            cache.save(key, kept, {"spp": spp, "seconds": spent + elapsed})
            if report is not None:
                now = goal.now(reference, mask)
                # The variance falls as 1 / batches, and time may run out.
                done = (goal.standard_error / now) ** 2 if now > 0.0 else 1.0
                report(
                    f"{goal.name} {spp} spp, error {now:.2g} (goal {goal.standard_error:.2g})",
                    min(1.0, max(done, elapsed / goal.max_seconds if goal.max_seconds else 1.0)),
                )
    return reference
