"""What planning saves: passes and time of planned frames against full ones, scene by scene.

``make bench-effects`` runs ``python -m benchmarks.planning_gain [SCENE ...]``; without scenes, on
all the built-in ones. Every round draws one frame of each kind in turn, so that all meet the same
load, and each round gives one ratio; medians over rounds are printed. Where OpenGL runs on
processors, the time is processor time of all threads: other programs cannot lengthen it
by taking their turn.
"""

from __future__ import annotations

import statistics
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import date
from pathlib import Path

from benchmarks.common import answering, check_scenes, command, positive, size_of
from ssdo_gl.gpu.context import create_context
from ssdo_gl.options.resolve import settings_for
from ssdo_gl.render_result import FrameTimes
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import builtin_names, load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

PICTURE = ("display",)
GBUFFER = ("depth", "normal_ws", "albedo")
# An odd number, so that the median is one of them.
ROUNDS = 7
# Planning takes microseconds; that many in a row average out the clock.
STATIC_FRAMES = 31


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
    for name in options.scenes or builtin_names():
        scene = load_scene(name)
        print(f"{scene.title or name} ...", file=sys.stderr, flush=True)
        settings = settings_for(scene.render, flags)
        costs.append(measure(Path(name).name, scene, settings, options.rounds))
    print(table_of(costs))
    print()
    device = create_context("auto")
    machine = f"{device.renderer}, OpenGL {device.version}"
    device.release()
    width, height = options.size
    print(f"{width}x{height}, medians of {options.rounds} rounds, {date.today()}; {machine}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
