"""Images and errors of a bench, made by workers with the numbers of one process.

Times are never theirs: a time is measured by the process that was called, when they are done.
"""

from __future__ import annotations

import platform
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from ssdo_gl.bench.measure import BenchRenderer
from ssdo_gl.farm.scheduler import FarmJob, connected
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

Task = tuple[Scene, Settings, str, str]


class Measurer:
    """Carries out measurements on a worker.

    Parameters
    ----------
    task : (Scene, Settings, str, str)
        What a renderer is made of, its backend, and what OpenGL must be called.

    Raises
    ------
    RuntimeError
        If another OpenGL draws here: errors would be those of two.
    """

    def __init__(self, task: Task) -> None:
        scene, settings, backend, device_name = task
        self._renderer = Renderer(scene, settings, backend=backend)
        own = self._renderer.device.renderer
        if own != device_name:
            self.close()
            raise RuntimeError(f"a worker draws with {own}, this machine with {device_name}")

    def make(self, item: tuple[Callable[[BenchRenderer, Any], Any], Any]) -> Any:
        """Return what a function measures of its argument."""
        measure, argument = item
        return measure(BenchRenderer(self._renderer), argument)

    def close(self) -> None:
        """Free the renderer."""
        self._renderer.release()


class SpreadRenderer(BenchRenderer):
    """A renderer that has workers measure what there is to measure of many items."""

    def __init__(self, renderer: Renderer, job: FarmJob) -> None:
        super().__init__(renderer)
        self._job = job

    def each(
        self,
        measure: Callable[[BenchRenderer, Any], Any],
        items: Sequence[Any],
        *,
        chunk: int | None = None,
    ) -> Generator[Any, None, None]:
        """Yield ``measure(renderer, item)`` of each item, as workers return it."""
        return self._job.results(items, shared=measure, chunk=chunk)


@contextmanager
def spread(renderer: BenchRenderer, scheduler: str | None) -> Iterator[tuple[BenchRenderer, str]]:
    """Yield a renderer that has the workers of `scheduler`, and a sentence that says so.

    At the end none of them is at work for it any more. Without a scheduler it is `renderer`
    itself, and the sentence is empty.

    Raises
    ------
    FarmError
    """
    if scheduler is None:
        yield renderer, ""
        return
    inner = renderer.renderer
    task = inner.scene, inner.settings, renderer.device.backend, renderer.device_name
    with connected(scheduler) as farm:
        machines = ", ".join(f"{count} on {name}" for name, count in farm.machines().items())
        sentence = (
            f"Images and errors were made by workers ({machines}), with the numbers that one"
            f" process gets; times were measured by one process on {platform.node()}, when"
            " these had nothing more to do."
        )
        yield SpreadRenderer(inner, farm.job(Measurer, task)), sentence
        farm.settle()
