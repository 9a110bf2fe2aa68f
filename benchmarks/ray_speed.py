"""Rays and paths per second, here and in Embree and Mitsuba, on the same scenes.

``make bench-rays`` runs ``python -m benchmarks.ray_speed [SCENE ...]``. Embree and Mitsuba
come with the ``test`` extra; what is not installed, or breaks, is left out and said so. The
others run in processes of their own: a compiler that fails inside Mitsuba ends its process.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from benchmarks.common import answering, check_scenes, command
from benchmarks.mitsuba_scene import (
    compared_scene,
    load_mitsuba,
    mitsuba_scene,
    render,
)
from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.raytracing.bvh import cached_bvh
from ssdo_gl.raytracing.triangles import scene_triangles
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

SCENES = ("cornell_meso", "stairs", "colonnade")
AO_SIZE = (320, 240)
AO_RAYS = 64
PATH_SIZE = (150, 150)
PATH_COUNTS = (16, 64)
# The best of several runs: what else the machine does can only slow a run down.
REPEATS = 4
# Embree gets this many of the rays that we trace, in their order.
EMBREE_RAYS = 400_000
# The compiled variant first; the scalar one runs anywhere.
MITSUBA_VARIANTS = ("llvm_ad_rgb", "scalar_rgb")
# The wider of the two tables, columns.
TABLE_WIDTH = 100
# What each worker may take before it is given up, seconds.
WORKER_LIMIT_S = 600.0


@dataclass(frozen=True)
class OcclusionSpeed:
    """Millions of occlusion rays per second of CPU time; NaN where not measured."""

    scene: str
    triangle_count: int
    radius: float
    ours: float
    embree: float


@dataclass(frozen=True)
class PathSpeed:
    """CPU milliseconds of an image and the error of its pixels, relative to the mean."""

    scene: str
    paths: int
    ours_ms: float
    ours_error: float
    mitsuba_ms: float
    mitsuba_error: float
    variant: str


def best_seconds(run: Callable[[], object]) -> float:
    """Return the least CPU time of `run`, which is first called once to warm up.

    CPU time of all threads: it does not depend on what else the machine does.
    """
    run()
    times = []
    for _ in range(REPEATS):
        start = time.process_time()
        run()
        times.append(time.process_time() - start)
    return min(times)


def reference_seconds(
    device: Device, scene: Scene, settings: Settings, output: str, name: str
) -> tuple[float, dict[str, Any], NDArray[np.float32]]:
    """Return the seconds of the tracing, the statistics of pass `name`, and the depth image.

    Seconds of CPU time on a software renderer, by the wall clock on a hardware one.
    """
    clock = time.process_time if device.is_software else time.perf_counter
    times = []
    with Renderer(scene, settings, device=device) as renderer:
        result = renderer.render([output, "depth"])
        for seed in range(1, REPEATS + 1):
            # Another seed: only what depends on random numbers is made again.
            renderer.settings = dataclasses.replace(renderer.settings, seed=seed)
            start = clock()
            renderer.render([output])
            times.append(clock() - start)
    return min(times), result.references[name], result.images["depth"]


def measure_occlusion(device: Device, name: str, radius: float | None) -> OcclusionSpeed:
    """Time ambient occlusion of a built-in scene; `radius` None: the scene's own."""
    scene = load_scene(name)
    reach = float(scene.render.get("radius", scene.default_radius())) if radius is None else radius
    settings = Settings(method="reference-ao", size=AO_SIZE, spp=AO_RAYS, radius=reach)
    seconds, _, depth = reference_seconds(device, scene, settings, "visibility", "reference_ao")
    covered = int(np.count_nonzero(depth > 0.0))
    embree = _embree_speed(scene, _embree_rays(scene, depth[..., 0]), reach)
    ours = covered * AO_RAYS / seconds / 1e6
    return OcclusionSpeed(name, scene.triangle_count, reach, ours, embree)


def _embree_rays(scene: Scene, depth: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return origins and directions (N, 6), normalised frame, as the shader draws them.

    Pixel after pixel over all of the picture, one ray each, all from the same cell of the
    hemisphere, then the next cell.
    """
    triangles = scene_triangles(scene)
    camera, (height, width) = scene.camera, depth.shape
    view = camera.view_from_world_rotation()
    tan_x, tan_y = camera.tan_half_fov(width / height)
    x = (2.0 * (np.arange(width) + 0.5) / width - 1.0) * tan_x
    y = (1.0 - 2.0 * (np.arange(height) + 0.5) / height) * tan_y
    rays = np.stack(np.broadcast_arrays(x[None, :], y[:, None], -1.0), axis=-1) @ view
    position = np.asarray(camera.position) + rays * depth[..., None]
    # Normals from neighbouring positions: wrong at edges only, which costs no time.
    normal = np.cross(np.gradient(position, axis=1), -np.gradient(position, axis=0))
    normal = normal[depth > 0.0]
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    rng = np.random.default_rng(1)
    cells = 8
    per_cell = min(len(normal), EMBREE_RAYS // cells**2)
    chosen = np.linspace(0, len(normal) - 1, per_cell).astype(np.int64)
    start = (position[depth > 0.0][chosen] - triangles.centre) / triangles.half_diagonal
    normal = normal[chosen]
    helper = np.where(np.abs(normal[:, :1]) < 0.9, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    tangent = np.cross(helper, normal)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-30)
    bitangent = np.cross(normal, tangent)
    parts = []
    for cell in np.ndindex(cells, cells):
        u = (np.array(cell) + rng.uniform(size=(per_cell, 2))) / cells
        r, angle = np.sqrt(u[:, :1]), 2.0 * np.pi * u[:, 1:]
        w = r * (np.cos(angle) * tangent + np.sin(angle) * bitangent)
        w += np.sqrt(1.0 - u[:, :1]) * normal
        parts.append(np.concatenate([start + 1e-5 * normal, w], axis=1))
    return np.concatenate(parts).astype(np.float32)


def _embree_speed(scene: Scene, rays: NDArray[np.float32], radius: float) -> float:
    """Return millions of rays per second of CPU time, NaN if Embree is not to be had."""
    triangles = scene_triangles(scene)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "rays.npz"
        reach = min(radius / triangles.half_diagonal, 1e9)
        np.savez(path, triangles=triangles.positions, rays=rays, reach=reach)
        result = _run_worker(["embree", str(path)])
    return result["rays_per_second"] / 1e6 if result else np.nan


def embree_worker(path: str) -> dict[str, Any]:
    """Trace the rays in `path` through Embree for some seconds."""
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    data = np.load(path)
    scene = EmbreeScene()
    TriangleMesh(scene, data["triangles"])
    origins = np.ascontiguousarray(data["rays"][:, :3])
    directions = np.ascontiguousarray(data["rays"][:, 3:])
    reach = np.full(len(origins), float(data["reach"]), dtype=np.float32)

    def run() -> None:
        scene.run(origins, directions, dists=reach, query="OCCLUDED")

    return {"rays_per_second": len(origins) / best_seconds(run)}


def measure_paths(device: Device, name: str, paths: int) -> PathSpeed:
    """Time the path tracer of a built-in scene, here and in Mitsuba."""
    scene = compared_scene(name)
    settings = Settings(method="reference-gi", size=PATH_SIZE, spp=paths)
    seconds, statistics, _ = reference_seconds(device, scene, settings, "beauty", "reference_gi")
    error = statistics["relative_standard_error"]["gi_radiance"]
    theirs: dict[str, Any] = {"seconds": np.nan, "error": np.nan}
    used = "-"
    for variant in MITSUBA_VARIANTS:
        result = _run_worker(["mitsuba", name, str(paths), variant])
        if result:
            theirs, used = result, variant
            break
    return PathSpeed(
        name, paths, seconds * 1e3, error, theirs["seconds"] * 1e3, theirs["error"], used
    )


def mitsuba_worker(name: str, paths: int, variant: str) -> dict[str, Any]:
    """Render a built-in scene with Mitsuba's path tracer."""
    mi = load_mitsuba(variant)
    scene = compared_scene(name)
    with tempfile.TemporaryDirectory() as folder:
        loaded = mitsuba_scene(mi, scene, Path(folder))
        images: list[NDArray[np.float64]] = []

        def run() -> None:
            # Its independent sampler gives other noise for another seed only.
            seed = len(images)
            images.append(render(mi, loaded, scene.camera, PATH_SIZE, -1, paths, seed))

        seconds = best_seconds(run)
    spread = np.std(images, axis=0, ddof=1)
    error = float(np.sqrt(np.mean(spread**2)) / np.mean(images))
    return {"seconds": seconds, "error": error}


def _run_worker(arguments: Sequence[str]) -> dict[str, Any]:
    """Return what a worker prints; empty if it failed."""
    command = [sys.executable, "-m", "benchmarks.ray_speed", "--worker", *arguments]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=WORKER_LIMIT_S, check=False
        )
    except subprocess.TimeoutExpired:
        return {}
    if done.returncode != 0:
        return {}
    result: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return result


def _number(value: float, digits: int = 1) -> str:
    return "-" if np.isnan(value) else f"{value:.{digits}f}"


def occlusion_table(rows: Sequence[OcclusionSpeed]) -> Table:
    """Return the occlusion rays as a table."""
    table = Table(title="ambient occlusion: millions of rays per CPU second")
    for heading in ("scene", "triangles", "R", "here", "Embree", "share"):
        table.add_column(heading, justify="left" if heading == "scene" else "right")
    for row in rows:
        table.add_row(
            row.scene,
            str(row.triangle_count),
            f"{row.radius:g}",
            _number(row.ours),
            _number(row.embree),
            _number(row.ours / row.embree, 2),
        )
    return table


def path_table(rows: Sequence[PathSpeed]) -> Table:
    """Return the path-traced images as a table."""
    table = Table(title=f"path tracing, {PATH_SIZE[0]}x{PATH_SIZE[1]}: CPU milliseconds an image")
    headings = ("scene", "paths", "here", "error", "Mitsuba", "error", "variant", "equal error")
    for heading in headings:
        table.add_column(heading, justify="left" if heading in ("scene", "variant") else "right")
    for row in rows:
        # Time goes with the inverse square of the error.
        ratio = (row.ours_ms * row.ours_error**2) / (row.mitsuba_ms * row.mitsuba_error**2)
        table.add_row(
            row.scene,
            str(row.paths),
            _number(row.ours_ms, 0),
            f"{row.ours_error:.1%}",
            _number(row.mitsuba_ms, 0),
            "-" if np.isnan(row.mitsuba_error) else f"{row.mitsuba_error:.1%}",
            row.variant,
            _number(ratio, 2),
        )
    return table


@answering
def main(argv: Sequence[str] | None = None) -> int:
    """Measure and print, or run as a worker for one of the others."""
    parser = command("ray_speed", __doc__)
    parser.add_argument("scenes", nargs="*", default=SCENES, metavar="SCENE")
    parser.add_argument("--worker", nargs="+", help=argparse.SUPPRESS)
    options = parser.parse_args(argv)
    if options.worker:
        kind, *rest = options.worker
        if kind == "embree":
            print(json.dumps(embree_worker(rest[0])))
        else:
            print(json.dumps(mitsuba_worker(rest[0], int(rest[1]), rest[2])))
        return 0
    check_scenes(options.scenes)
    # A pipe is taken for 80 columns, in which names would be cut short.
    console = Console() if sys.stdout.isatty() else Console(width=TABLE_WIDTH)
    device = create_context()
    clock = "CPU time" if device.is_software else "the wall clock; others: CPU time"
    console.print(f"{device.renderer}, {os.cpu_count()} CPU cores; here: {clock}")
    occlusion, paths = [], []
    for name in options.scenes:
        start = time.perf_counter()
        cached_bvh(load_scene(name))
        console.print(f"{name}: hierarchy built in {time.perf_counter() - start:.1f} s")
        for radius in (None, np.inf):
            occlusion.append(measure_occlusion(device, name, radius))
        for count in PATH_COUNTS:
            paths.append(measure_paths(device, name, count))
    device.release()
    console.print(occlusion_table(occlusion))
    console.print(path_table(paths))
    console.print("equal error: our time over Mitsuba's for images of the same error")
    return 0


if __name__ == "__main__":
    sys.exit(main())
