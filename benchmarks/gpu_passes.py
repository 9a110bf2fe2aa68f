"""Times of passes on a GPU, beside the least time in which their bytes can be moved."""

from __future__ import annotations

import statistics
import time
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from ssdo_gl import resources
from ssdo_gl.bench.measure.machine import CLOCK_NAMES
from ssdo_gl.bench.report import COLORS
from ssdo_gl.gpu.compute import compute_source
from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.program import Program
from ssdo_gl.gpu.shader import FULLSCREEN, read_shader
from ssdo_gl.gpu.shader_source import flatten
from ssdo_gl.gpu.texture import make_framebuffer, make_texture
from ssdo_gl.gpu.timer import Timer
from ssdo_gl.planning.planner import Planner
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

FRAMES = 15
# Bytes of a channel, by moderngl's name of its type.
BYTES = {"f4": 4, "f2": 2, "nu1": 1, "nu2": 2, "u4": 4}
# Texels of 16 bytes, copied to measure bandwidth: far more than any cache holds.
COPY_SIDE = 4096
COPY = """#version 330 core
uniform sampler2D t_source;
layout(location = 0) out vec4 o_copy;
void main() { o_copy = texelFetch(t_source, ivec2(gl_FragCoord.xy), 0); }
"""
# Devices at rest slow their clocks down; frames of this long, seconds, bring them up.
WARM_UP = 0.4


def copy_bandwidth(device: Device, side: int) -> float:
    """Return bytes per second, read and written, of a copy of `side` x `side` texels."""
    # Noise: what a driver compresses would be copied faster than it can be read.
    noise = np.random.default_rng(0).random((side, side, 4), dtype=np.float32)
    source, target = (make_texture(device.gl, (side, side), 4, "f4", noise) for _ in range(2))
    framebuffer = make_framebuffer(device.gl, [target])
    vertex = flatten(FULLSCREEN, partial(read_shader, resources.folder("shaders")))
    way = (lambda _, fragment: compute_source(fragment)) if device.computes else None
    program = Program(device.gl, vertex, flatten("<copy>", lambda _: COPY), way)
    timer, times = Timer(device), []
    # The first ones wake a device whose clock has slowed down.
    for _ in range(40):
        with timer:
            draw_fullscreen(device.gl, program, framebuffer, {}, {"t_source": source})
        times.append(timer.elapsed_ms)
    for item in (framebuffer, source, target):
        item.release()
    return 2.0 * noise.nbytes / (min(times) * 1e-3)


def bytes_of_passes(renderer: Renderer) -> dict[str, int]:
    """Return how many bytes each pass must read and write at least, each texel once.

    Tables of the scene, shadow maps and depth buffers are left out: a floor.
    """
    settings = renderer.settings
    plan = Planner().plan(renderer.scene, renderer.scene, settings, ("display",), None).graph
    texels: dict[str, int] = {}
    for item in plan.order:
        for name, spec in item.writes.items():
            if not spec.own:
                width, height = spec.size(settings.size)
                texels[name] = width * height * spec.components * BYTES[spec.dtype]
    return {
        item.name: sum(texels.get(name, 0) for name in (*item.reads, *item.writes))
        for item in plan.order
    }


def pass_rows(
    device: Device, scene: Scene, preset: str, settings: Settings, bandwidth: float, *, quick: bool
) -> list[dict[str, Any]]:
    """Return what each pass, and the frame, take, and how far passes are above their floors."""
    frames = 2 if quick else FRAMES
    width, height = settings.size
    head = {"preset": preset, "method": settings.method, "width": width, "height": height}
    head["shaders"] = "compute" if device.computes else "fragment"
    with Renderer(scene, settings, device=device) as renderer:
        timer = CLOCK_NAMES["gpu"] if renderer.timer_kind == "gl_query" else CLOCK_NAMES["wall"]
        floors = bytes_of_passes(renderer)
        begin = time.monotonic()
        renderer.render(("display",))  # compiles, and lets all light converge
        first = [(time.monotonic() - begin) * 1e3]
        begin, number = time.monotonic(), 0
        while time.monotonic() - begin < (0.0 if quick else WARM_UP):
            number += 1
            renderer.time_frame(("display",), number=-number)
        frame, drawn, rest = _frame_times(device, renderer, frames)
        times: dict[str, list[float]] = {}
        for number in range(frames):
            timed = renderer.time_frame(("display",), number=number + 1, time_passes=True)
            for row in timed.passes:
                if row.ran and row.gpu_ms is not None:
                    times.setdefault(row.name, []).append(row.gpu_ms)
    rows = []
    for name, values in times.items():
        floor = floors.get(name, 0) / bandwidth * 1e3
        ms = statistics.median(values)
        rows.append(
            head
            | {"pass": name, "ms": round(ms, 4), "low_ms": round(min(values), 4)}
            | {"floor_ms": round(floor, 4), "megabytes": round(floors.get(name, 0) / 1e6, 2)}
            | {"over_floor": round(ms / floor, 1) if floor else "", "timer": timer}
        )
    kinds = {"frame, the first": first, "frame": frame}
    kinds |= {"frame, drawn": drawn, "frame, view at rest": rest}
    for kind, values in kinds.items():
        clock = "until finish()" if values is first or values is frame else timer
        took = {"pass": kind, "ms": round(statistics.median(values), 4), "timer": clock}
        rows.append(head | took | {"low_ms": round(min(values), 4)})
    return rows


def _frame_times(
    device: Device, renderer: Renderer, frames: int
) -> tuple[list[float], list[float], list[float]]:
    """Return milliseconds of whole frames: until they are there, of the device, and at rest.

    The last are those of a window whose camera does not move, by the device's clock.
    """
    whole, drawn, rest, timer = [], [], [], Timer(device)
    for number in range(1, frames + 1):
        whole.append(renderer.time_frame(("display",), number=number).frame_ms)
    for number in range(1, frames + 1):
        with timer:
            renderer.time_frame(("display",), number=frames + number)
        drawn.append(timer.elapsed_ms)
    for index in range(frames + 1):
        with timer:
            renderer.draw(("display",), camera=renderer.scene.camera, index=index, count=frames + 1)
        rest.append(timer.elapsed_ms)
    return whole, drawn, rest[1:]


def draw_passes(rows: Sequence[Mapping[str, Any]]) -> Any:
    """Return a figure of the passes of `gi`, preset balanced, at each size."""
    from matplotlib.figure import Figure

    shown = [row for row in rows if row["preset"] == "balanced" and row["method"] == "gi"]
    shown = [row for row in shown if row["shaders"] == shown[0]["shaders"]]
    shown = [row for row in shown if not row["pass"].startswith("frame")]
    sizes = list(dict.fromkeys((row["width"], row["height"]) for row in shown))
    figure = Figure(figsize=(5.0 * max(len(sizes), 1), 4.5), layout="constrained")
    charts = figure.subplots(1, max(len(sizes), 1), squeeze=False)[0]
    for chart, (width, height) in zip(charts, sizes, strict=False):
        members = [row for row in shown if (row["width"], row["height"]) == (width, height)]
        places = np.arange(len(members))
        chart.barh(places, [row["ms"] for row in members], color=COLORS[5], label="measured")
        floors = [row["floor_ms"] for row in members]
        chart.barh(places, floors, height=0.35, color=COLORS[8], label="bandwidth floor")
        chart.set_yticks(places, [row["pass"] for row in members])
        chart.invert_yaxis()
        chart.set_xscale("log")
        chart.set_xlabel("ms")
        chart.set_title(f"balanced gi, {width}x{height}")
        chart.legend(fontsize=7)
    return figure
