"""Frames on a GPU: by compute shaders that draw triangles or the rasterizer, and of a window."""

from __future__ import annotations

import dataclasses
import itertools
import statistics
import time
from collections.abc import Callable, Sequence
from typing import Any
from unittest.mock import patch

import numpy as np

from ssdo_gl.bench.presets import load_preset
from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.geometry import triangle_rasterizer
from ssdo_gl.gpu.timer import Timer
from ssdo_gl.options.resolve import settings_for
from ssdo_gl.render_result import PassReport
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings
from ssdo_gl.window.live.live_image import REFINE_FRAMES

PRESET = "balanced"
TRIANGLE_SCENES = ("cornell_meso", "stairs", "colonnade")
TRIANGLE_SIZES = ((1920, 1080), (3840, 2160))
WINDOW_SCENES, WINDOW_SIZE = ("cornell_meso", "stairs"), (1920, 1080)
FRAMES = 15
# Devices at rest slow their clocks down; frames of this long, seconds, bring them up.
WARM_UP = 0.3
QUICK_SIZE = 64, 36
# A camera that moves by this share of its distance from what it looks at, each frame.
STEP = 5e-4
# Draws a frame by its number, and says what its passes took if they are timed.
DrawFrame = Callable[[int, bool], Sequence[PassReport]]


def triangle_rows(device: Device, *, quick: bool) -> list[dict[str, Any]]:
    """Return what frames of `bounce` take with triangles drawn by either way, and passes."""
    rows = []
    sizes = (QUICK_SIZE,) if quick else TRIANGLE_SIZES
    for name in TRIANGLE_SCENES[:1] if quick else TRIANGLE_SCENES:
        for size, way in itertools.product(sizes, ("compute shaders", "rasterizer")):
            with _rasterized(way == "rasterizer"), _renderer(device, name, "bounce", size) as r:
                head = {"scene": name, "triangles": r.scene.triangle_count}
                head |= {"width": size[0], "height": size[1], "way": way}
                rows.append(head | _medians(device, _new_view(r), quick=quick))
    return rows


def window_rows(device: Device, *, quick: bool) -> list[dict[str, Any]]:
    """Return what frames of a window take while its camera moves, and that refine its view."""
    rows = []
    size = QUICK_SIZE if quick else WINDOW_SIZE
    scenes = WINDOW_SCENES[:1] if quick else WINDOW_SCENES
    for name, method in itertools.product(scenes, ("bounce", "gi")):
        with _renderer(device, name, method, size) as renderer:
            for kind, draw in (("camera moves", _moving(renderer)), ("refined", _still(renderer))):
                # What is gathered over frames at rest, rays above all, is there before.
                for n in range(2 * REFINE_FRAMES):
                    draw(n, False)
                head = {"scene": name, "method": method, "frame kind": kind}
                rows.append(head | _medians(device, draw, quick=quick))
    return rows


def _new_view(renderer: Renderer) -> DrawFrame:
    return lambda n, timed: (
        renderer.time_frame(("display",), number=n + 1, time_passes=timed).passes
    )


def _moving(renderer: Renderer) -> DrawFrame:
    """Return what draws from cameras of steps to the side, there and back."""
    camera = renderer.scene.camera
    position = np.array(camera.position)
    side = np.cross(np.array(camera.target) - position, camera.up)
    steps = [*range(FRAMES), *range(FRAMES, 0, -1)]
    places = [tuple((position + STEP * n * side).tolist()) for n in steps]
    cameras = [dataclasses.replace(camera, position=place) for place in places]
    return lambda n, timed: (
        renderer.draw(("display",), camera=cameras[n % len(cameras)], time_passes=timed).passes
    )


def _still(renderer: Renderer) -> DrawFrame:
    return lambda n, timed: (
        renderer.draw(
            ("display",),
            camera=renderer.scene.camera,
            index=n,
            count=REFINE_FRAMES,
            time_passes=timed,
        ).passes
    )


def _rasterized(is_rasterized: bool) -> Any:
    most = 0 if is_rasterized else triangle_rasterizer.MOST_BATCHES
    return patch.object(triangle_rasterizer, "MOST_BATCHES", most)


def _renderer(device: Device, name: str, method: str, size: tuple[int, int]) -> Renderer:
    scene = load_scene(name)
    fields = {**load_preset(PRESET), "method": method, "size": size}
    settings: Settings = settings_for(scene.render, fields)
    return Renderer(scene, settings, device=device)


def _medians(device: Device, draw: DrawFrame, *, quick: bool) -> dict[str, float]:
    """Return milliseconds of the frame, and of each of its passes."""
    timer, count = Timer(device), 2 if quick else FRAMES
    begin, number = time.monotonic(), 0
    while number == 0 or time.monotonic() - begin < (0.0 if quick else WARM_UP):
        draw(number, False)
        number += 1
    found: dict[str, list[float]] = {"frame": []}
    for n in range(number, number + count):
        with timer:
            draw(n, False)
        found["frame"].append(timer.elapsed_ms)
    for n in range(number + count, number + 2 * count):
        for row in draw(n, True):
            if row.ran and row.gpu_ms is not None:
                found.setdefault(row.name, []).append(row.gpu_ms)
    return {name: round(statistics.median(values), 3) for name, values in found.items()}
