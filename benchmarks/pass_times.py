"""Milliseconds of every pass, beside the paper's method as published.

``make bench-passes`` runs ``python -m benchmarks.pass_times [SCENE]``, which prints a table in
Markdown. All settings are rendered in turn, round after round, so that a machine that speeds up or
slows down does so for all of them; the table holds medians, and ratios of medians. Where OpenGL
runs on processors, times are processor time of all threads, which other programs cannot lengthen
by taking their turn.
"""

from __future__ import annotations

import dataclasses
import statistics
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack

from benchmarks.common import answering, command, positive
from ssdo_gl.bench.measure.machine import CLOCK_NAMES, cpu_name, load_average
from ssdo_gl.bench.presets import load_preset
from ssdo_gl.gpu.context import create_context
from ssdo_gl.options.resolve import settings_for
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

SIZE = (640, 360)
ROUNDS = 15
# The paper's SSDO with one bounce: 8 uniform directions, one point each, a 4x4 blur.
BASELINE = "rgs09, 8 samples, naive blur"


def columns(scene: Scene) -> Iterator[tuple[str, Settings]]:
    """Yield what is compared: a name and its settings."""

    def settings(**flags: object) -> Settings:
        return settings_for(scene.render, {"size": SIZE, **flags})

    yield BASELINE, settings(method="bounce", estimator="rgs09", samples=8, filter="naive")
    yield "direct", settings(method="direct")
    yield "ssao, 16 samples", settings(method="ssao", samples=16)
    for preset in ("fast", "balanced", "fine"):
        yield f"preset {preset}", settings(method="bounce", **load_preset(preset, "bounce"))
    yield "bounce", settings(method="bounce")
    yield "gi, the default", settings(method="gi")


def measure(scene: Scene, rounds: int) -> dict[str, dict[str, float]]:
    """Return the median milliseconds of every pass (and of the ``frame``) by column."""
    times: dict[str, dict[str, list[float]]] = {}
    device = create_context()
    with ExitStack() as stack:
        stack.callback(device.release)
        renderers = {
            name: stack.enter_context(Renderer(scene, settings, device=device))
            for name, settings in columns(scene)
        }
        for renderer in renderers.values():
            renderer.render(frames=2)
            if device.is_software:
                renderer.timer.clock = time.process_time
        for _ in range(rounds):
            for name, renderer in renderers.items():
                row = times.setdefault(name, {})
                # Frames are timed whole and passes apart: a pass that is waited for cannot
                # overlap the next one.
                frames = renderer.render(["display"], frames=2)
                taken = frames.process_ms if device.is_software else frames.frame_ms
                row.setdefault("frame", []).extend(taken)
                for item in renderer.render(["display"], frames=2, time_passes=True).passes:
                    if item.ran and item.gpu_ms is not None:
                        row.setdefault(item.name, []).append(item.gpu_ms)
    return {
        name: {item: statistics.median(values) for item, values in row.items()}
        for name, row in times.items()
    }


def table(times: dict[str, dict[str, float]]) -> str:
    """Return a Markdown table: passes down, settings across, ratios at the end."""
    names = list(times)
    passes = list(dict.fromkeys(item for row in times.values() for item in row if item != "frame"))
    base = times[BASELINE]["frame"]
    lines = [
        "| pass, ms | " + " | ".join(names) + " |",
        "|---" * (len(names) + 1) + "|",
    ]
    for item in passes:
        cells = [f"{times[n][item]:.1f}" if item in times[n] else "" for n in names]
        lines.append(f"| `{item}` | " + " | ".join(cells) + " |")
    frames = [f"**{times[n]['frame']:.1f}**" for n in names]
    ratios = [f"{times[n]['frame'] / base:.2f}" for n in names]
    lines.append("| whole frame | " + " | ".join(frames) + " |")
    lines.append("| over the baseline | " + " | ".join(ratios) + " |")
    return "\n".join(lines)


@answering
def main(argv: Sequence[str] | None = None) -> int:
    """Measure and print."""
    parser = command("pass_times", __doc__)
    parser.add_argument("scene", nargs="?", default="cornell_meso", metavar="SCENE")
    parser.add_argument("--rounds", type=positive, default=ROUNDS)
    options = parser.parse_args(argv)
    source, rounds = options.scene, options.rounds
    scene = load_scene(source)
    with Renderer(scene, dataclasses.replace(Settings(), size=(1, 1))) as renderer:
        device, is_software = renderer.device.renderer, renderer.device.is_software
    print(table(measure(scene, rounds)))
    clock = CLOCK_NAMES["process" if is_software else "wall"]
    print(f"\n{source}, {SIZE[0]}x{SIZE[1]}, medians of {2 * rounds} frames; {device};", end=" ")
    print(f"{clock};", end=" ")
    print(f"{cpu_name()}; load {load_average()}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
