"""Other renderers on the same clock: VTK's SSAO, three.js' SSAO, GTAO and SSGI, and ours.

``make bench-peers`` runs ``python -m benchmarks.peers OUTDIR``, which writes peers.csv, peers.md
and everybody's visibility as a PNG into OUTDIR. All draw the same room, from the same place, at
the same size, with the same reach of occlusion; that the cameras agree is checked by depth before
anything is timed. Times are medians of rounds in which everybody takes a turn; errors are RMSE of
visibility against rays.

A peer that is not there is left out, and the table says why. VTK: pip install --no-deps vtk.
three.js: npm install three, and --three DIR says where; playwright and chromium draw it.
"""

from __future__ import annotations

import math
import re
import statistics
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.common import answering, command, size_of
from benchmarks.peer_room import NoPeerError, Peer, PeerTimes, Room, make_room
from benchmarks.peer_three import Three
from benchmarks.peer_vtk import Vtk
from ssdo_gl.bench.measure.machine import core_count, cpu_name, load_average
from ssdo_gl.bench.measure.sweep import order
from ssdo_gl.bench.presets import load_preset
from ssdo_gl.bench.storage import csv_bytes, replace_file
from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.images.files import png_bytes
from ssdo_gl.options.resolve import settings_for
from ssdo_gl.renderer import Renderer
from ssdo_gl.settings import Settings

SIZE, RADIUS = (640, 360), 0.3
ROUNDS, FRAMES, TRACED_SPP = 5, 3, 256
# What times are multiples of: the first that is there.
UNITS = ("VTK SSAO-16 + blur", "ssao, hemisphere 16")
# Cameras agree if less than a share of all depths differs by more than a share of itself.
DEPTH_SHARE, DEPTH_DIFFERENCE = 0.01, 0.01
# Ours: what is drawn, and settings. Occlusion alone first, as peers have it.
_ssao = partial(dict[str, Any], method="ssao", shadows="none")
OURS: dict[str, tuple[str, dict[str, Any]]] = {
    "direct, no shadow": ("", {"method": "direct", "shadows": "none"}),
    "ssao, hemisphere 16": ("occlusion", _ssao(estimator="hemisphere", samples=16)),
    "ssao, hemisphere 64": ("occlusion", _ssao(estimator="hemisphere", samples=64)),
    "ssao, hbao 16": ("occlusion", _ssao(estimator="hbao", samples=16, steps=4)),
    "ssao, gtao 16": ("occlusion", _ssao(estimator="gtao", samples=16, steps=4)),
    "ssao, bitmask 24": ("occlusion", _ssao(estimator="bitmask", samples=24, steps=6)),
    "direct": ("shadows", {"method": "direct"}),
    "preset fast": ("shadows, SSDO, bounce", {**load_preset("fast"), "method": "bounce"}),
    "preset balanced": ("shadows, SSDO, bounce", {**load_preset("balanced"), "method": "bounce"}),
    "bounce": ("shadows, SSDO, bounce", {"method": "bounce"}),
    "gi": ("shadows, SSDO, all bounces", {"method": "gi"}),
    "published SSDO": (
        "shadows, SSDO, bounce",
        {"method": "bounce", "estimator": "rgs09", "samples": 8, "filter": "naive"},
    ),
}


@dataclass(frozen=True, eq=False)
class Contestant:
    """Somebody who draws the room: what beyond surfaces and a lamp, how, and how fast."""

    name: str
    draws: str
    timed: Callable[[int], PeerTimes]
    visibility: NDArray[np.float64] | None
    times: list[PeerTimes] = field(default_factory=list)

    @property
    def wall_ms(self) -> float:
        """The median by the wall clock."""
        return statistics.median(t.wall_ms for t in self.times)

    @property
    def process_ms(self) -> float:
        """The median of all processors' time."""
        return statistics.median(t.process_ms for t in self.times)


@dataclass(frozen=True, eq=False)
class Traced:
    """Visibility by rays, how much of its mean square is noise, and depth."""

    visibility: NDArray[np.float64]
    variance: float
    depth: NDArray[np.float64]

    def error(self, visibility: NDArray[np.float64]) -> float:
        """Return the root mean square error, without the noise of the rays."""
        square = float(np.mean((visibility - self.visibility) ** 2))
        return math.sqrt(max(square - self.variance, 0.0))

    def best_error(self, visibility: NDArray[np.float64]) -> float:
        """Return the error when all occlusion is made stronger or weaker by the best factor."""
        wanted, found = 1.0 - self.visibility, 1.0 - visibility
        square = float(np.sum(found**2))
        return self.error(1.0 - found * (float(np.sum(found * wanted)) / square if square else 1.0))

    def check_camera(self, depth: NDArray[np.float64]) -> None:
        """Raise NoPeerError unless `depth` was seen from where ours was."""
        apart = np.abs(depth - self.depth) > DEPTH_DIFFERENCE * self.depth
        if (share := float(np.mean(apart))) > DEPTH_SHARE:
            raise NoPeerError(f"its depth differs from ours in {share:.1%} of the pixels")


def trace(room: Room, device: Device, spp: int) -> Traced:
    """Return what visibility is compared with: two independent halves, averaged."""
    halves = []
    for seed in (0, 1):
        settings = _settings(room, method="reference-ao", spp=spp // 2, seed=seed)
        with Renderer(room.scene, settings, device=device) as renderer:
            images = renderer.render(("visibility", "depth")).images
        halves.append(images["visibility"][:, :, 0].astype(np.float64))
    variance = float(np.mean((halves[0] - halves[1]) ** 2)) / 4.0
    depth = images["depth"][:, :, 0].astype(np.float64)
    return Traced((halves[0] + halves[1]) / 2.0, variance, depth)


def _settings(room: Room, **fields: Any) -> Settings:
    return settings_for({}, {"size": room.size, "radius": room.radius, **fields})


def own_contestants(room: Room, device: Device, stack: ExitStack) -> Iterator[Contestant]:
    """Yield ours, each with a renderer of its own, so that all stay warm."""
    for name, (draws, fields) in OURS.items():
        settings = _settings(room, **fields)
        renderer = stack.enter_context(Renderer(room.scene, settings, device=device))
        visibility = None
        if settings.method != "direct":
            image = renderer.render(("visibility",)).images["visibility"]
            visibility = image[:, :, 0].astype(np.float64)
        yield Contestant(name, draws, partial(_time_ours, renderer), visibility)


def _time_ours(renderer: Renderer, frames: int) -> PeerTimes:
    result = renderer.render(("display",), frames=frames)
    return PeerTimes(statistics.mean(result.frame_ms), statistics.mean(result.process_ms))


def peer_contestants(peer: Peer, traced: Traced) -> list[Contestant]:
    """Return what a peer draws; raises NoPeerError if it looks from elsewhere."""
    traced.check_camera(peer.depth())
    found = []
    for name, draws in peer.variants.items():
        visibility = peer.visibility(name) if draws else None
        found.append(Contestant(name, draws, partial(peer.timed, name), visibility))
    return found


def race(contestants: Sequence[Contestant], rounds: int) -> None:
    """Time everybody in turn, round after round, each round in another order."""
    for number in range(rounds):
        for index in order(number, len(contestants)):
            contestants[index].times.append(contestants[index].timed(FRAMES))


def rows_of(contestants: Sequence[Contestant], traced: Traced) -> list[dict[str, Any]]:
    """Return what is known of everybody, as the CSV has it."""
    by_name = {c.name: c for c in contestants}
    unit = next(by_name[name] for name in UNITS if name in by_name)
    rows = []
    for c in contestants:
        errors = (math.nan, math.nan)
        if c.visibility is not None:
            errors = traced.error(c.visibility), traced.best_error(c.visibility)
        rows.append(
            {
                "renderer": c.name,
                "draws": c.draws,
                "wall_ms": round(c.wall_ms, 2),
                "process_ms": round(c.process_ms, 2),
                "time": round(c.process_ms / unit.process_ms, 3),
                "error": round(errors[0], 4),
                "error_best_strength": round(errors[1], 4),
            }
        )
    return rows


def table(rows: Sequence[dict[str, Any]]) -> Iterator[str]:
    """Yield a Markdown table, fastest first."""
    yield "| renderer | draws, beyond one lamp | wall, ms | processors, ms | time | error | best |"
    yield "|---|---|---|---|---|---|---|"
    for row in sorted(rows, key=lambda row: float(row["process_ms"])):
        times = f"{row['wall_ms']:.0f} | {row['process_ms']:.0f} | {row['time']:.2f}"
        both = f"{row['error']:.3f} | {row['error_best_strength']:.3f}"
        errors = both.replace("0.", ".").replace("nan", "")
        yield f"| {row['renderer']} | {row['draws']} | {times} | {errors} |"


def measure(
    room: Room, makers: dict[str, Callable[[Room], Peer]], rounds: int
) -> tuple[list[Contestant], Traced, list[str]]:
    """Return everybody, rays, and lines that say who drew on what, and who was left out."""
    with ExitStack() as stack:
        peers, notes = {}, []
        for name, make in makers.items():
            try:
                peers[name] = make(room)
            except NoPeerError as error:
                notes.append(f"skipped {name}: {error}")
            else:
                stack.callback(peers[name].close)
        # Later than they, and so closed before: a window of VTK ends EGL for all.
        device = create_context()
        stack.callback(device.release)
        notes.append(f"ours on {device.renderer}")
        traced = trace(room, device, TRACED_SPP)
        contestants = list(own_contestants(room, device, stack))
        for name, peer in peers.items():
            try:
                contestants += peer_contestants(peer, traced)
                notes += [f"{name} on {peer.device}", *peer.notes]
            except NoPeerError as error:
                notes.append(f"skipped {name}: {error}")
        race(contestants, rounds)
        return contestants, traced, notes


@answering
def main(argv: Sequence[str] | None = None) -> int:
    """Measure, write and print."""
    parser = command("peers", __doc__)
    parser.add_argument("outdir", type=Path, metavar="OUTDIR")
    parser.add_argument("--three", type=Path, metavar="DIR", help="where three.js was installed")
    parser.add_argument("--size", type=size_of, default=SIZE, metavar="WxH")
    parser.add_argument("--rounds", type=int, default=ROUNDS, choices=range(1, 100), metavar="N")
    options = parser.parse_args(argv)
    if options.three is not None and not options.three.is_dir():
        parser.error(f"--three {options.three}: there is no such folder")
    room = make_room(options.size, RADIUS)
    makers: dict[str, Callable[[Room], Peer]] = {
        "VTK": Vtk,
        "three.js": partial(Three, folder=options.three),
    }
    options.outdir.mkdir(parents=True, exist_ok=True)
    contestants, traced, notes = measure(room, makers, options.rounds)
    rows = rows_of(contestants, traced)
    replace_file(options.outdir / "peers.csv", csv_bytes(rows))
    seen = {c.name: c.visibility for c in contestants if c.visibility is not None}
    for name, visibility in {"rays": traced.visibility, **seen}.items():
        levels = np.round(255.0 * np.clip(visibility, 0.0, 1.0)).astype(np.uint8)
        path = options.outdir / (re.sub(r"[^a-z0-9]+", "-", name.lower()) + ".png")
        replace_file(path, png_bytes(levels[:, :, None]))
    width, height = room.size
    conditions = (
        f"{width}x{height}, R {room.radius:g}; medians of {options.rounds} rounds of {FRAMES} "
        f"frames; {cpu_name()}, {core_count()} cores, load {load_average()}; "
        f"{time.strftime('%Y-%m-%d')}; {'; '.join(notes)}"
    )
    text = "\n".join([*table(rows), "", conditions, ""])
    replace_file(options.outdir / "peers.md", text.encode())
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
