"""Errors of `gi` in motion at equal time: averages over frames, and single frames.

Motions of `benchmarks.motion_errors`, drawn as a window draws them, against `reference-gi` of the
same views. The kinds of frames take turns, so that what else runs meets all of them. Printed are,
for each kind, processor time as a multiple of that of averaged frames, RMSE over the mean
radiance, the averages' error over it, and temporal error and its RMS as `benchmarks.walk_errors`
has them. The paths' noise is no part of them.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.common import answering, command, positive
from benchmarks.motion_errors import CASES, Case, rendered
from benchmarks.walk_errors import errors
from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings

Images = NDArray[np.float32]
# The frames until averages are as long as they get are not judged.
LEAD = 16
# Of light that moves by itself nothing is averaged but with bodies: left out.
MOTIONS = ("pan, 1/8 px", "pan, 2 px", "dolly", "disocclusion", "carousel, lamps at rest")
AVERAGED = "averaged"
# One frame has march and probes; as many samples as averages' rays take time for; and these rays.
KINDS: Mapping[str, Mapping[str, Any]] = {
    AVERAGED: {},
    "single": {"temporal": "off"},
    "single, 160 samples": {"temporal": "off", "samples": 160},
    "single, the same rays": {
        "overrides": {"temporal.frames_of_rays": 1, "temporal.frames_of_moving_bodies": 1}
    },
}


@dataclass(frozen=True)
class Extent:
    """How much is drawn: `frames` of them are judged."""

    size: tuple[int, int]
    frames: int
    spp: int


def references(device: Device, case: Case, extent: Extent, seed: int) -> Images:
    """Return the judged frames (frames, height, width, 3) by paths."""
    scene = load_scene(case.scene)
    settings = Settings("reference-gi", size=extent.size, spp=extent.spp, seed=seed, exposure=0.0)
    numbers = range(LEAD, LEAD + extent.frames)
    views = (case.at(scene, number, extent.size[1]) for number in numbers)
    return rendered(device, scene, settings, views)["beauty"]


def turned(kinds: list[str], number: int) -> list[str]:
    """Return them in the order in which frame `number` is drawn."""
    first = number % len(kinds)
    return kinds[first:] + kinds[:first]


def live(device: Device, case: Case, extent: Extent) -> dict[str, tuple[Images, list[float]]]:
    """Return the judged frames of each kind, and the seconds that each of them took."""
    scene = load_scene(case.scene)
    images: dict[str, list[Images]] = {kind: [] for kind in KINDS}
    spent: dict[str, list[float]] = {kind: [] for kind in KINDS}
    with ExitStack() as stack:
        renderers = {}
        for kind, changes in KINDS.items():
            settings = Settings("gi", size=extent.size, exposure=0.0, **changes)
            renderers[kind] = stack.enter_context(Renderer(scene, settings, device=device))
        for number in range(LEAD + extent.frames):
            moved, camera, seconds = case.at(scene, number, extent.size[1])
            # Each is the first of them now and then, which finds what moves not yet brought along.
            for kind in turned(list(KINDS), number):
                renderer = renderers[kind]
                renderer.use_scene(moved)
                start = time.process_time()
                drawn = renderer.draw(["display", "beauty"], camera=camera, seconds=seconds)
                spent[kind].append(time.process_time() - start)
                if number >= LEAD:
                    images[kind].append(drawn.planes["beauty"].read()[..., :3])
    return {kind: (np.stack(images[kind]), spent[kind][LEAD:]) for kind in KINDS}


def rows(device: Device, name: str, extent: Extent) -> Iterator[str]:
    """Yield the rows of a motion."""
    pair = [references(device, CASES[name], extent, seed)[None] for seed in (1, 2)]
    found = live(device, CASES[name], extent)
    told = {kind: errors(images[None], *pair) for kind, (images, _) in found.items()}
    for kind, (_, spent) in found.items():
        ratio = float(np.median(spent) / np.median(found[AVERAGED][1]))
        share = told[AVERAGED].error / told[kind].error if told[kind].error else float("nan")
        yield (
            f"| {name} | {kind} | {ratio:.2f} | {told[kind].error:.4f} | {share:.2f} "
            f"| {told[kind].temporal:.4f} | {told[kind].rms:.4f} |"
        )


@answering
def main(argv: Sequence[str] | None = None) -> int:
    """Measure and print."""
    parser = command("motion_equal_time", __doc__)
    parser.add_argument("--cases", nargs="+", choices=CASES, default=MOTIONS)
    parser.add_argument("--size", type=int, nargs=2, default=(320, 180), metavar=("W", "H"))
    parser.add_argument("--frames", type=positive, default=5, help="that are judged")
    parser.add_argument("--spp", type=positive, default=96, help="paths of either reference")
    options = parser.parse_args(argv)
    size = Settings(size=tuple(options.size)).checked().size
    extent = Extent(size, options.frames, options.spp)
    device = create_context()
    print("| motion | frames | time | error | averaged over it | temporal error | RMS |")
    print("|---|---|--:|--:|--:|--:|--:|")
    for name in options.cases:
        for row in rows(device, name, extent):
            print(row, flush=True)
    print(f"{size[0]}x{size[1]}, {extent.spp} paths; {device.renderer}")
    device.release()
    return 0


if __name__ == "__main__":
    sys.exit(main())
