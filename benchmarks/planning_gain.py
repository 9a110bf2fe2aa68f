"""What planning saves: passes and time of planned frames against full ones, scene by scene.

``make bench-effects`` runs ``python -m benchmarks.planning_gain [SCENE ...]``; without scenes, on
all the built-in ones. Every round draws one frame of each kind in turn, so that all meet the same
load, and each round gives one ratio; medians over rounds are printed. Where OpenGL runs on
processors, the time is processor time of all threads: other programs cannot lengthen it
by taking their turn.
"""

from __future__ import annotations

import math
import statistics
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import date
from pathlib import Path

import numpy as np

from benchmarks.common import answering, check_scenes, command, positive, size_of
from ssdo_gl.gpu.context import create_context
from ssdo_gl.planning.bodies import bodies_of
from ssdo_gl.planning.content import analyse
from ssdo_gl.render_result import FrameTimes
from ssdo_gl.renderer import Renderer
from ssdo_gl.resources import folder
from ssdo_gl.scene.geometry import shapes
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.resolve import settings_for

PICTURE = ("display",)
GBUFFER = ("depth", "normal_ws", "albedo")
# An odd number, so that the median is one of them.
ROUNDS = 7
# Planning takes microseconds; that many in a row average out the clock.
STATIC_FRAMES = 31
# What a scene without an effect may take of the full pipeline's time, and what deciding
# may take in milliseconds.
LEAN_SCENE, MOST_LEAN = "corner", 0.5
MOST_GBUFFER, MOST_STATIC = 0.25, 0.1
MOST_PLANNING_MS, MOST_ANALYSIS_MS = 0.2, 50.0
ANALYSED_TRIANGLES = 300_000


@dataclass(frozen=True)
class SceneCost:
    """What frames of one scene take.

    Attributes
    ----------
    passes_run, passes_possible : int
        Of a picture: as planned, and all that some plan of it has.
    planned_ms, full_ms : float
        Medians.
    planned, gbuffer, static : float
        Medians of the ratios to the full picture: a planned picture, a planned request
        for the G-buffer alone, a planned picture of which nothing has changed.
    planning_ms, replanning_ms : float
        Deciding what runs, for the same view as before and for another.
    """

    scene: str
    passes_run: int
    passes_possible: int
    planned_ms: float
    full_ms: float
    planned: float
    gbuffer: float
    static: float
    planning_ms: float
    replanning_ms: float


def measure(name: str, scene: Scene, settings: Settings, rounds: int = ROUNDS) -> SceneCost:
    """Return what frames of `scene` take."""
    device = create_context("auto")
    kinds = {"planned": PICTURE, "gbuffer": GBUFFER, "full": PICTURE}
    renderers: dict[str, Renderer] = {}
    for kind in kinds:
        effects = "full" if kind == "full" else "auto"
        shaders = next(iter(renderers.values())).shaders if renderers else None
        chosen = replace(settings, effects=effects, antialias=1)
        renderers[kind] = Renderer(scene, chosen, device=device, shaders=shaders)

    def taken(times: FrameTimes) -> float:
        return times.process_ms if device.is_software else times.frame_ms

    rows: list[dict[str, float]] = []
    planning: list[float] = []
    last: dict[str, FrameTimes] = {}
    for number in range(rounds + 1):
        for kind, wanted in kinds.items():
            last[kind] = renderers[kind].time_frame(wanted, number=number)
        static = renderers["planned"].time_frame(PICTURE, number=number)
        # The first round compiles programs and makes shadow maps.
        if number > 0:
            row = {kind: taken(times) for kind, times in last.items()}
            rows.append({**row, "static": taken(static)})
    for _ in range(STATIC_FRAMES):
        planning.append(renderers["planned"].time_frame(PICTURE, number=rounds).planning_ms)
    replanning = _replanning(renderers["planned"], scene)
    names = {
        kind: {r.name for r in last[kind].passes if r.ran or "kept" in r.reason} for kind in kinds
    }
    for renderer in renderers.values():
        renderer.release()
    device.release()

    def ratio(kind: str) -> float:
        return statistics.median(row[kind] / row["full"] for row in rows)

    return SceneCost(
        name,
        len(names["planned"]),
        len(names["full"] | names["planned"]),
        statistics.median(row["planned"] for row in rows),
        statistics.median(row["full"] for row in rows),
        ratio("planned"),
        ratio("gbuffer"),
        ratio("static"),
        statistics.median(planning),
        statistics.median(replanning),
    )


def _replanning(renderer: Renderer, scene: Scene) -> list[float]:
    """Return planning times of views each of which differs from the one before."""
    x, y, z = scene.camera.position
    times = []
    for number in range(STATIC_FRAMES):
        # A millionth of the distance: another view, and the same things in it.
        camera = replace(scene.camera, position=(x, y, z * (1.0 + 1e-6 * (number + 1)) + 1e-9))
        times.append(renderer.time_frame(("depth",), camera=camera, number=number).planning_ms)
    return times


def table_of(costs: Sequence[SceneCost]) -> str:
    """Return the costs as a table in Markdown; times in milliseconds, ratios to full."""
    lines = [
        "| scene | passes | planned | full | ratio | G-buffer | unchanged | planning | new view |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {cost.scene} | {cost.passes_run} of {cost.passes_possible}"
        f" | {cost.planned_ms:.1f} | {cost.full_ms:.1f} | {cost.planned:.2f}"
        f" | {cost.gbuffer:.3f} | {cost.static:.4f}"
        f" | {cost.planning_ms:.4f} | {cost.replanning_ms:.2f} |"
        for cost in costs
    ]
    return "\n".join(lines)


def analysis_ms() -> dict[str, float]:
    """Return what finding out what is in 300 000 triangles takes, by what they make up.

    The least of several times: whatever else runs only ever adds to it.
    """
    camera = load_scene(LEAN_SCENE).camera
    side = math.isqrt(ANALYSED_TRIANGLES)
    meshes = {
        "a torus": shapes.torus(0.3, segments=side, tube_segments=side // 2),
        "balls": shapes.sphere(),
        "pebbles": shapes.sphere(16),
        "boxes": shapes.box(),
    }
    times: dict[str, float] = {}
    for name, mesh in meshes.items():
        count = max(ANALYSED_TRIANGLES // len(mesh.triangles), 1)
        places = np.tile(np.eye(4), (count, 1, 1))
        places[:, :3, 3] = np.random.default_rng(0).uniform(-9.0, 9.0, (count, 3))
        # Many boxes are instances of one, as scenes have them; else each has its own mesh.
        parts = [places] if name == "boxes" else list(places[:, None])
        objects = tuple(SceneObject(i, 0, part) for i, part in enumerate(parts))
        taken = []
        for _ in range(ROUNDS):
            # What is found out about a mesh is remembered with it, so each time new ones.
            fresh = tuple(replace(mesh) for _ in parts)
            scene = Scene(fresh, (Material(),), objects, camera)
            start = time.perf_counter()
            analyse(scene)
            bodies_of(scene)
            taken.append((time.perf_counter() - start) * 1e3)
        times[f"{name}, {count * len(mesh.triangles)} triangles"] = min(taken)
    return times


def targets_of(costs: Sequence[SceneCost], analysis: Mapping[str, float]) -> str:
    """Return what was aimed at beside the worst that was measured, as a table."""
    rows = [
        (f"`{cost.scene}` as planned, over the full pipeline", MOST_LEAN, cost.planned)
        for cost in costs
        if cost.scene == LEAN_SCENE
    ]
    worst = {
        "the G-buffer alone, over the full pipeline": (MOST_GBUFFER, "gbuffer"),
        "a frame of which nothing changed, over the full pipeline": (MOST_STATIC, "static"),
        "planning where nothing changed, ms": (MOST_PLANNING_MS, "planning_ms"),
    }
    for text, (limit, name) in worst.items():
        rows.append((text, limit, max(float(getattr(cost, name)) for cost in costs)))
    rows += [
        (f"finding out what is in {name}, ms", MOST_ANALYSIS_MS, ms)
        for name, ms in analysis.items()
    ]
    lines = ["| target | at most | measured | met |", "|---|---|---|---|"]
    lines += [
        f"| {text} | {limit:g} | {value:.3g} | {'yes' if value <= limit else 'no'} |"
        for text, limit, value in rows
    ]
    return "\n".join(lines)


def built_in_scenes() -> list[str]:
    """Return the names of the scenes that come with the program."""
    names = (entry.name for entry in folder("scenes").iterdir())
    return sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml"))


@answering
def main(argv: Sequence[str] | None = None) -> int:
    """Print the table for the scenes named on the command line."""
    parser = command("planning_gain", __doc__)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="default: all built-in ones")
    parser.add_argument("--size", type=size_of, default=(640, 360), metavar="WxH")
    parser.add_argument("--method", default=None)
    parser.add_argument("--rounds", type=positive, default=ROUNDS)
    options = parser.parse_args(argv)
    flags = {"size": options.size, "method": options.method}
    settings_for({}, flags)
    check_scenes(options.scenes)
    costs = []
    for name in options.scenes or built_in_scenes():
        scene = load_scene(name)
        print(f"{scene.title or name} ...", file=sys.stderr, flush=True)
        settings = settings_for(scene.render, flags)
        costs.append(measure(Path(name).name, scene, settings, options.rounds))
    print(table_of(costs))
    print()
    print(targets_of(costs, analysis_ms()))
    print()
    device = create_context("auto")
    machine = f"{device.renderer}, OpenGL {device.version}"
    device.release()
    width, height = options.size
    print(f"{width}x{height}, medians of {options.rounds} rounds, {date.today()}; {machine}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
