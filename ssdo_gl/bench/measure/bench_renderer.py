"""The only way from a bench to the renderer: images, frame times, pass times."""

from __future__ import annotations

import dataclasses
import math
import statistics
import time
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

ItemT = TypeVar("ItemT")
ResultT = TypeVar("ResultT")
Images = Mapping[str, NDArray[np.float32]]


@dataclass(frozen=True)
class MedianTimes:
    """Times of warm frames, milliseconds.

    Attributes
    ----------
    frame_ms : float
        Median until the device had finished, by the wall clock.
    process_ms : float
        Median processor time of all threads.
    gpu_ms : float
        Sum over the passes of the median of OpenGL's time queries; NaN on a software
        rasterizer, whose queries are wrong.
    setup_ms : float
        The frame before them: with shader compilation and uploads if it was the first.
    """

    frame_ms: float
    process_ms: float
    gpu_ms: float
    setup_ms: float


class BenchRenderer:
    """What a bench needs of a renderer; its shaders and geometry stay warm between settings."""

    def __init__(self, renderer: Renderer) -> None:
        self.renderer = renderer
        self.device = renderer.device
        self.device_name = renderer.device.renderer
        self.scene = renderer.scene

    @contextmanager
    def of_scene(self, scene: Scene) -> Iterator[BenchRenderer]:
        """Yield a renderer of another scene on the same device."""
        with Renderer(scene, device=self.device) as renderer:
            yield BenchRenderer(renderer)

    def images(self, settings: Settings, wanted: Sequence[str]) -> Images:
        """Return the images `wanted`, rendered once."""
        self.renderer.use(settings)
        return self.renderer.render(wanted).whole().images

    def each(
        self,
        measure: Callable[[BenchRenderer, ItemT], ResultT],
        items: Sequence[ItemT],
        *,
        chunk: int | None = None,
    ) -> Generator[ResultT, None, None]:
        """Yield ``measure(renderer, item)`` of each item in their order, when asked for it.

        Parameters
        ----------
        measure : callable
            Can be pickled; what it returns depends on nothing else.
        chunk : int or None
            Where workers do it, how many items each takes at a time.
        """
        for item in items:
            yield measure(self, item)

    def why_spared(self, settings: Settings, effect: str) -> str | None:
        """Return why the plan of a picture spares `effect`; None where it does not."""
        self.renderer.use(settings)
        decisions = self.renderer.render(("beauty",)).decisions
        return next((d.reason for d in decisions if d.effect == effect and not d.run), None)

    def timed(self, settings: Settings, wanted: Sequence[str], frames: int) -> MedianTimes:
        """Return times of `frames` warm frames that each recompute the whole view."""
        self.renderer.use(settings)
        # One frame alone would be the cold one; the median of two needs a third to be
        # robust, and costs little more.
        queries = self.renderer.timer_kind == "gl_query"
        result = self.renderer.render(wanted, frames=max(frames, 2), time_passes=queries).whole()
        by_pass = [row.gpu_ms for row in result.passes if row.gpu_ms is not None]
        return MedianTimes(
            statistics.median(result.frame_ms),
            statistics.median(result.process_ms),
            sum(by_pass) if queries else math.nan,
            result.setup_ms,
        )

    def split(
        self, settings: Settings, wanted: Sequence[str], frames: int, clock: str
    ) -> tuple[tuple[str, float], ...]:
        """Return (pass, median ms by one of `CLOCKS`) of what runs in a warm frame, in order."""
        self.renderer.use(settings)
        self.renderer.timer.clock = time.process_time if clock == "process" else time.perf_counter
        result = self.renderer.render(wanted, frames=max(frames, 2), time_passes=True).whole()
        return tuple((row.name, row.gpu_ms) for row in result.passes if row.gpu_ms is not None)


def images_of_seed(
    renderer: BenchRenderer, seed: int, settings: Settings, wanted: Sequence[str]
) -> Images:
    """Return the images `wanted` with another seed than that of `settings`."""
    return renderer.images(dataclasses.replace(settings, seed=seed), wanted)
