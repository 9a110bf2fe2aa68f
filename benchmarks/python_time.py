"""Processor time that Python takes to issue a steady frame, apart from drawing it.

On a GPU the passes of a frame take a fraction of a millisecond; what Python needs to issue
them is then the time of the frame. ``make bench-python`` draws frames so small that there is
next to nothing to shade, and prints a table in Markdown. *Python* is the processor time of
the issuing thread without what passes inside draws, clears and the wait at the end of a frame,
which stands under *driver*; moderngl's calls that set uniforms, textures, targets and state
belong to Python. Calls are those of all functions, and those of moderngl's objects.

Frames are *still* (the camera stands, all that depends on the view is computed anew),
*refined* (a window averages a view at rest) or *moving* (a window flies).
"""

from __future__ import annotations

import cProfile
import dataclasses
import gc
import pstats
import statistics
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any
from unittest import mock

import moderngl

from benchmarks.common import answering, command, positive
from ssdo_gl.bench.measure.machine import cpu_name, load_average
from ssdo_gl.bench.presets import load_preset
from ssdo_gl.options.resolve import settings_for
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

SIZE = (16, 16)
FRAMES = 300
# Until shaders are compiled and histories are full.
WARM_UP = 40
MOTIONS = ("still", "refined", "moving")
# Sub-pixel offsets of a window, and the one that it flies with.
OFFSETS, CENTRE = 16, 7
# Cameras of a flight before it begins anew: more than any view is remembered for.
FLIGHT = 500
# Where the time is the driver's.
DRAWS: tuple[tuple[type[Any], str], ...] = (
    (moderngl.VertexArray, "render"),
    (moderngl.ComputeShader, "run"),
    (moderngl.Framebuffer, "clear"),
    (moderngl.Context, "finish"),
)


@dataclass(frozen=True)
class FrameCost:
    """What one steady frame takes.

    Attributes
    ----------
    python_ms, driver_ms : float
        Medians of the issuing thread's processor time.
    calls, gl_calls : int
        Of functions in all, and of those of moderngl's objects; setting a property of one
        counts as a call of Python alone.
    """

    python_ms: float
    driver_ms: float
    calls: int
    gl_calls: int


def rows(scene: Scene) -> Iterator[tuple[str, Settings]]:
    """Yield what is measured: a name and its settings."""

    def settings(**flags: object) -> Settings:
        return settings_for(scene.render, {"size": SIZE, **flags})

    yield "direct", settings(method="direct")
    yield "bounce, preset balanced", settings(method="bounce", **load_preset("balanced", "bounce"))
    yield "bounce", settings(method="bounce")
    yield "gi", settings(method="gi")


def drawing(renderer: Renderer, motion: str) -> Callable[[int], object]:
    """Return what draws frame number N of a motion."""
    camera = renderer.scene.camera
    x, y, z = camera.position
    places = [(x + 1e-4 * number, y + 1e-4 * number, z) for number in range(FLIGHT)]
    flight = [dataclasses.replace(camera, position=place) for place in places]

    def draw(number: int) -> object:
        if motion == "still":
            return renderer.time_frame(["display"], number=number)
        if motion == "refined":
            index = number % OFFSETS
            return renderer.draw(["display"], camera=camera, index=index, count=OFFSETS)
        moved = flight[number % FLIGHT]
        return renderer.draw(["display"], camera=moved, index=CENTRE, count=OFFSETS)

    return draw


def measure(renderer: Renderer, motion: str, frames: int) -> FrameCost:
    """Return what a steady frame takes."""
    draw = drawing(renderer, motion)
    for number in range(WARM_UP):
        draw(number)
    times: list[tuple[float, float]] = []
    with _timed_draws() as spent:
        for number in range(WARM_UP, WARM_UP + frames):
            spent[0] = 0.0
            start = time.thread_time()
            draw(number)
            times.append((time.thread_time() - start - spent[0], spent[0]))
    python_ms, driver_ms = (1e3 * statistics.median(column) for column in zip(*times, strict=True))
    return FrameCost(python_ms, driver_ms, *_calls(draw, WARM_UP + frames))


def _calls(draw: Callable[[int], object], number: int) -> tuple[int, int]:
    """Return how many functions a frame calls, and how many methods of moderngl's objects."""
    profile = cProfile.Profile()
    # What others have left would be cleared away within the frame, and its finalizers counted.
    gc.collect()
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        # The next frame frees what the context holds of it.
        draw(number)
        profile.runcall(draw, number + 1)
    finally:
        if was_enabled:
            gc.enable()
    stats: Any = pstats.Stats(profile)
    counts = {name: row[1] for (_, _, name), row in stats.stats.items()}
    return stats.total_calls, sum(n for name, n in counts.items() if " of 'mgl." in name)


@contextmanager
def _timed_draws() -> Iterator[list[float]]:
    """Add up the seconds that the thread spends in `DRAWS`."""
    spent = [0.0]

    def timed(call: Callable[..., object]) -> Callable[..., object]:
        def wrapper(*args: object, **keywords: object) -> object:
            start = time.thread_time()
            try:
                return call(*args, **keywords)
            finally:
                spent[0] += time.thread_time() - start

        return wrapper

    with ExitStack() as stack:
        for owner, name in DRAWS:
            stack.enter_context(mock.patch.object(owner, name, timed(getattr(owner, name))))
        yield spent


@answering
def main(argv: Sequence[str] | None = None) -> int:
    """Measure and print."""
    parser = command("python_time", __doc__)
    parser.add_argument("scene", nargs="?", default="cornell_meso", metavar="SCENE")
    parser.add_argument("--frames", type=positive, default=FRAMES, metavar="N")
    options = parser.parse_args(argv)
    scene = load_scene(options.scene)
    print("| method | frames | Python, ms | driver, ms | calls | of moderngl |")
    print("|---|---|---|---|---|---|")
    for name, settings in rows(scene):
        for motion in MOTIONS:
            with Renderer(scene, settings) as renderer:
                cost, device = measure(renderer, motion, options.frames), renderer.device.renderer
            times = f"{cost.python_ms:.2f} | {cost.driver_ms:.2f}"
            print(f"| {name} | {motion} | {times} | {cost.calls} | {cost.gl_calls} |", flush=True)
    print(f"\n{options.scene}, medians of {options.frames} frames; {device};", end=" ")
    print(f"{cpu_name()}; load {load_average()}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
