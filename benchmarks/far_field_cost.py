"""What `gi` takes beside `bounce`: time to prepare a scene, and memory.

``make bench-light-cost`` runs ``python -m benchmarks.far_field_cost [SCENE ...]``. *Prepared* is
the time that the first picture takes more than those after it, in seconds of all processors, of a
scene that was just loaded and by programs that are compiled: the hierarchy for rays, the places
of the surface cache, what its rays meet, and all bounces. Memory is that of the process, which
holds all textures where OpenGL runs on processors, MiB more than with `bounce`: *held* after a
window's frames in motion and at rest, and the *peak*. Each number has a process of its own.
"""

from __future__ import annotations

import dataclasses
import gc
import multiprocessing
import resource
import statistics
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.common import answering, check_scenes, command, size_of
from ssdo_gl.bench.measure.machine import cpu_name, load_average
from ssdo_gl.gpu.context import create_context
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.process import give_back_memory
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.window.panel.status import memory_mb

SCENES = ("cornell_meso", "colonnade")
SIZE = (640, 360)
METHODS = ("bounce", "gi")
# Pictures whose median is a warm one.
WARM = 3
# Frames of a flight, and of a view at rest: the offsets of a window's average, and a few more.
MOVED, RESTED, OFFSETS = 12, 20, 16
MIB = 2.0**20
# Of all axes.
GROWN = np.array([1.0 + 1e-9] * 3 + [1.0])[:, None]


@dataclass(frozen=True)
class Cost:
    """What a method takes in one scene.

    Attributes
    ----------
    prepared_s : float
        Processor time that the first picture takes more than those after it, seconds.
    held_mib, peak_mib : float
        Memory of the process.
    """

    prepared_s: float
    held_mib: float
    peak_mib: float


# Each of the two is for a process that has done nothing yet.


def prepared_s(source: str, method: str, size: tuple[int, int]) -> float:
    """Return the processor time that the first picture takes more than those after it."""
    settings = Settings(method, size=size)
    device = create_context("auto")
    try:
        shaders = ShaderLibrary(device.gl, computes=device.computes)
        keywords: dict[str, Any] = {"device": device, "shaders": shaders}
        # Compiles all programs. What is made from geometry is kept for each content, which that
        # of the scene that is measured must not be.
        with Renderer(nudged(load_scene(source)), settings, **keywords) as renderer:
            renderer.render(["beauty"])
        with Renderer(load_scene(source), settings, **keywords) as renderer:
            first, *warm = [_seconds(renderer) for _ in range(1 + WARM)]
    finally:
        device.release()
    return first - statistics.median(warm)


def memory_mib(source: str, method: str, size: tuple[int, int]) -> tuple[float, float]:
    """Return what the process of a window holds, and the most that it held, MiB."""
    with Renderer(load_scene(source), Settings(method, size=size)) as renderer:
        renderer.render(["beauty"])
        live(renderer)
        gc.collect()
        give_back_memory()
        held = memory_mb() * 1e6 / MIB
    # Linux counts in KiB, macOS in bytes.
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return held, peak / MIB if sys.platform == "darwin" else peak / 1024.0


def nudged(scene: Scene) -> Scene:
    """Return a scene as large as another but for a billionth."""
    objects = tuple(
        dataclasses.replace(item, world_from_object=item.world_from_object * GROWN)
        for item in scene.objects
    )
    return dataclasses.replace(scene, objects=objects)


def _seconds(renderer: Renderer) -> float:
    start = time.process_time()
    renderer.render(["beauty"])
    return time.process_time() - start


def measure(source: str, method: str, size: tuple[int, int]) -> Cost:
    """Return what a method takes in a scene, in processes of their own."""
    # Forked ones would begin with the memory of this one.
    context = multiprocessing.get_context("spawn")
    with context.Pool(1) as pool:
        seconds = pool.apply(prepared_s, (source, method, size))
    with context.Pool(1) as pool:
        memory = pool.apply(memory_mib, (source, method, size))
    return Cost(seconds, *memory)


def live(renderer: Renderer) -> None:
    """Draw as a window does, so that all that it keeps is there."""
    camera = renderer.scene.camera
    x, y, z = camera.position
    for number in range(MOVED):
        place = dataclasses.replace(camera, position=(x + 1e-3 * number, y, z))
        renderer.draw(["display"], camera=place, index=0, count=OFFSETS)
    for number in range(RESTED):
        renderer.draw(["display"], camera=camera, index=number, count=OFFSETS)


@answering
def main(argv: Sequence[str] | None = None) -> int:
    """Print a row for each scene."""
    parser = command("far_field_cost", __doc__)
    parser.add_argument("scenes", nargs="*", default=SCENES, metavar="SCENE")
    parser.add_argument("--size", type=size_of, default=SIZE, metavar="WxH")
    options = parser.parse_args(argv)
    table = Table("scene", "triangles", "prepared, s", "of `bounce`", "held, MiB", "peak, MiB")
    check_scenes(options.scenes)
    size = options.size
    for source in options.scenes:
        triangles = load_scene(source).triangle_count
        costs = [measure(source, method, size) for method in METHODS]
        table.add_row(source, f"{triangles}", *cells(*costs))
    console = Console(highlight=False, soft_wrap=True)
    console.print(table)
    console.print(
        f"{size[0]}x{size[1]}, memory above that of `bounce`; {cpu_name()}, load", end=" "
    )
    console.print(f"{load_average()}, {time.strftime('%Y-%m-%d')}")
    return 0


def cells(near: Cost, far: Cost) -> list[str]:
    """Return what the table says of `gi` beside `bounce`."""
    return [
        f"{far.prepared_s:.1f}",
        f"{near.prepared_s:.1f}",
        f"{far.held_mib - near.held_mib:+.0f}",
        f"{far.peak_mib - near.peak_mib:+.0f}",
    ]


if __name__ == "__main__":
    sys.exit(main())
