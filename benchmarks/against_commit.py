"""Processor time of a window's frames, over that of the frames of an earlier commit.

``make bench-against`` with COMMIT=398b93d SCENES="corner stairs" checks the commit out beside
this tree, holds renderers of both warm, in processes of their own, and lets them draw in turn: a
view at rest that is refined, then a camera that sways, then lamps that move, or whatever the scene
moves. Each round gives a ratio of the time of some frames. The table has their medians: frames
by METHOD of this tree, over those by the other method of this tree and, in brackets, of the
commit; the commit's alone if both methods are the same. Other programs on the machine lengthen
both sides alike; how far single rounds lie apart is printed.
"""

from __future__ import annotations

import os
import statistics
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from benchmarks.checkout import ROOT, checked_out, full_name
from benchmarks.common import answering, check_scenes, command
from benchmarks.frame_side import NoCaseError, Side
from ssdo_gl.bench.measure.machine import core_count, cpu_name, load_average
from ssdo_gl.bench.storage import csv_bytes, json_bytes, replace_file
from ssdo_gl.images.files import check_output
from ssdo_gl.scene.load import builtin_names
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import parse

SIZE, ROUNDS, FRAMES = (640, 360), 7, 4
METHOD, OTHER_METHOD = "gi", "bounce"
CASES = {
    "still": "nothing moves",
    "camera": "the camera moves",
    "lamps": "lamps, and bodies, move",
}


@dataclass(frozen=True)
class Ratio:
    """What the frames of one case take, over those of another side.

    Attributes
    ----------
    over : str
        The other side.
    ms, other_ms : float
        Medians of the processor time of a frame, milliseconds.
    ratios : tuple of float
        One for each round.
    """

    scene: str
    case: str
    over: str
    ms: float
    other_ms: float
    ratios: tuple[float, ...]

    @property
    def median(self) -> float:
        """The median of the rounds."""
        return statistics.median(self.ratios)

    @property
    def spread(self) -> float:
        """Half the way between the quartiles of the rounds, over the median."""
        if len(self.ratios) < 2:
            return 0.0
        low, _, high = statistics.quantiles(self.ratios, n=4, method="inclusive")
        return (high - low) / 2.0 / self.median

    def row(self) -> dict[str, Any]:
        """Return it as plain data."""
        return {
            "scene": self.scene,
            "case": self.case,
            "over": self.over,
            "ratio": round(self.median, 4),
            "spread": round(self.spread, 4),
            "lowest": round(min(self.ratios), 4),
            "highest": round(max(self.ratios), 4),
            "rounds": len(self.ratios),
            "ms": round(self.ms, 3),
            "other_ms": round(self.other_ms, 3),
        }


def compare(case: str, scene: str, sides: Sequence[Side], rounds: int, frames: int) -> list[Ratio]:
    """Return how long frames of the first side take, over those of each other one.

    Raises NoCaseError where a side has none.
    """
    first = max([side.warm(case) for side in sides])
    taken: list[list[float]] = [[] for _ in sides]
    for number in range(rounds):
        turn = list(enumerate(sides))
        # What a side finds of the other one in the caches must not always be the same.
        for index, side in turn if number % 2 else turn[::-1]:
            taken[index].append(side.frames_ms(case, first + number * frames, frames))
    return [
        Ratio(
            scene,
            case,
            side.name,
            statistics.median(taken[0]),
            statistics.median(taken[index]),
            tuple(a / b for a, b in zip(taken[0], taken[index], strict=True)),
        )
        for index, side in enumerate(sides)
        if index > 0
    ]


def scene_rows(
    scene: str, jobs: Sequence[tuple[str, Path, dict[str, Any]]], cases: Sequence[str], how: Any
) -> Iterator[list[Ratio] | str]:
    """Yield the ratios of each case, or why it has none; the first job is held to the others."""
    with ExitStack() as stack:
        # All load at the same time.
        sides = [Side(name, tree, {**job, "scene": source_of(scene)}) for name, tree, job in jobs]
        for side in sides:
            stack.callback(side.close)
        for side in sides:
            side.loaded()
        for case in cases:
            print(f"{scene}: {CASES[case]} ...", file=sys.stderr, flush=True)
            try:
                yield compare(case, scene, sides, how.rounds, how.frames)
            except NoCaseError as error:
                yield str(error)


def source_of(scene: str) -> str:
    """Return what names a scene from everywhere."""
    is_file = scene not in builtin_names() and os.path.exists(scene)
    return os.path.abspath(scene) if is_file else scene


def cell_of(found: list[Ratio] | str) -> str:
    """Return what the table shows of a case: `1.18 (.87)`."""
    if isinstance(found, str):
        return found
    numbers = [f"{ratio.median:.2f}".removeprefix("0") for ratio in found]
    return numbers[0] + "".join(f" ({number})" for number in numbers[1:])


def table_of(cells: dict[str, list[str]], cases: Sequence[str]) -> Table:
    """Return the table, a row for each scene."""
    table = Table("scene")
    for case in cases:
        table.add_column(CASES[case], justify="right")
    for scene, row in cells.items():
        table.add_row(escape(scene), *row)
    return table


def write(path: Path, ratios: Sequence[Ratio], about: dict[str, Any]) -> None:
    """Write what was found, as JSON or CSV by the file's ending."""
    rows = [ratio.row() for ratio in ratios]
    is_table = path.suffix == ".csv"
    replace_file(path, csv_bytes(rows) if is_table else json_bytes({**about, "rows": rows}))


@answering
def main(argv: Sequence[str] | None = None) -> int:
    """Compare and print; 2 if a commit, a scene or a setting is not there."""
    parser = command("against_commit", __doc__)
    parser.add_argument("commit", metavar="COMMIT")
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="default: all built-in ones")
    parser.add_argument("--method", default=METHOD, help="of this tree")
    parser.add_argument("--other-method", default=OTHER_METHOD, help="of the commit")
    parser.add_argument("--size", default=f"{SIZE[0]}x{SIZE[1]}", metavar="WxH")
    parser.add_argument("--cases", nargs="+", choices=CASES, default=tuple(CASES))
    parser.add_argument("--rounds", type=int, default=ROUNDS, choices=range(1, 1000), metavar="N")
    parser.add_argument("--frames", type=int, default=FRAMES, choices=range(1, 1000), metavar="N")
    parser.add_argument("--output", type=Path, metavar="FILE", help=".json or .csv")
    return run(parser.parse_args(argv))


def run(options: Any) -> int:
    """Compare as the command line says, and print."""
    if options.output is not None:
        check_output(options.output, (".json", ".csv"))
    check_scenes(options.scenes)
    size, name = parse(Settings, "size", options.size), full_name(options.commit)[:9]
    here = {"settings": {"size": size, "method": options.method}}
    there = {"settings": {"size": size, "method": options.other_method}}
    cells: dict[str, list[str]] = {}
    ratios: list[Ratio] = []
    with checked_out(options.commit) as tree:
        jobs = [("this tree", ROOT, here)]
        if options.method != options.other_method:
            jobs.append((f"{options.other_method} of this tree", ROOT, there))
        jobs.append((f"{options.other_method} of {name}", tree, there))
        for scene in dict.fromkeys(options.scenes or builtin_names()):
            cells[scene] = []
            for found in scene_rows(scene, jobs, options.cases, options):
                cells[scene].append(cell_of(found))
                ratios += [] if isinstance(found, str) else found
    over = " (and over ".join(side for side, _, _ in jobs[1:]) + ")" * (len(jobs) - 2)
    spread = max((ratio.spread for ratio in ratios), default=0.0)
    about = {
        "what": f"processor time of frames by {options.method}, over {over}",
        "size": list(size),
        "how": f"medians of {options.rounds} ratios of {options.frames} frames each",
        "machine": f"{cpu_name()}, {core_count()} cores, load {load_average()}",
        "date": time.strftime("%Y-%m-%d"),
    }
    console = Console(highlight=False, soft_wrap=True)
    console.print(table_of(cells, options.cases))
    console.print(f"{about['what']}; {size[0]}x{size[1]}, {about['how']}")
    console.print(f"half of a case's ratios lie within {spread:.1%} of their median, at most")
    console.print(f"{about['machine']}; {about['date']}")
    if options.output is not None:
        write(options.output, ratios, about)
    return 0


if __name__ == "__main__":
    sys.exit(main())
